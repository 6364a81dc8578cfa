// ---- Path time: the position, 0 to 1, is proportional to it.

let position = 0;
const timeNow = () => start + position * duration;

/** Value of a number of the shapes at the current time, linear between shapes. JSON has null for NaN. */
function valueNow(of) {
  const { low, high, part } = shapePlace, from = of(shapes[low]) ?? NaN;
  return part > 0 ? from + part * ((of(shapes[high]) ?? NaN) - from) : from;
}

// ---- Curves against path time.

const MOST_CURVES = 24, MOST_NAMED = 12;
const PAD = { left: 40, right: 8, top: 6, bottom: 34 };
const DEGREE = 180 / Math.PI;
/** Pixels between two labels, one above the other, that do not lie over each other. */
const LINE = 14;

/** Curve of the angle of a group: `at` has its values at the shapes, `now` gives its value at the current time. */
function groupCurve(group) {
  const place = {}, at = shapeTimes.map(time => DEGREE * groupAngle(group, find(knotTimes, time, place)));
  return {
    group, at, name: `g${group}`, colour: `hsl(${Math.round(hue(group))} 62% var(--curve-light))`,
    now: () => DEGREE * groupAngle(group, knotPlace), text: value => `${value.toFixed(1)}°`,
  };
}
const curve = (name, colour, of, dash) => ({ name, colour, dash, at: shapes.map(shape => of(shape) ?? NaN), now: () => valueNow(of), text: short });

// Angles differ between groups. If there are many, the groups that are drawn are spread evenly over all.
const drawnGroups = Math.min(groups, MOST_CURVES);
const angleCurves = Array.from({ length: drawnGroups }, (_, i) => groupCurve(Math.floor(i * groups / drawnGroups)));
const errorCurves = [
  curve("deformation", "var(--deformation)", shape => shape.deformation),
  curve("gap", "var(--gap)", shape => shape.gap, "6 4"),
];
const clearanceCurves = [curve("clearance", "var(--clearance)", shape => shape.clearance)];
const clearanceKnown = shapes.some(shape => shape.clearance !== null);

const least = list => list.reduce((a, b) => Math.min(a, b));
const most = list => list.reduce((a, b) => Math.max(a, b));

/** Returns at most about `count` round numbers that cover a range. */
function ticks(low, high, steps, count) {
  const step = steps.find(step => (high - low) / step <= count) ?? (high - low);
  const first = Math.floor(low / step + 1e-9), end = Math.ceil(high / step - 1e-9);
  return Array.from({ length: end - first + 1 }, (_, i) => +((first + i) * step).toPrecision(12));
}
const DECIMAL = Array.from({ length: 36 }, (_, i) => [1, 2, 5][i % 3] * 10 ** (Math.floor(i / 3) - 6));
const DEGREES = [...DECIMAL.filter(step => step < 15), 15, 30, 45, 60, 90, 180];
const values = curves => curves.flatMap(({ at }) => at).filter(Number.isFinite);

/** Makes a linear axis that contains 0 and ends at round numbers. */
function evenAxis(curves, steps, smallest) {
  const all = [0, ...values(curves)];
  const marks = ticks(least(all), Math.max(smallest, most(all)), steps, 5);
  return { marks, label: x => String(x).replace("-", "−"), place: x => x };
}

/** Makes a logarithmic axis of powers of ten, with a row below the lowest power for zero, which has no logarithm. */
function errorAxis() {
  const all = values(errorCurves);
  const logs = all.filter(x => x > 0).map(Math.log10);
  const top = logs.length ? Math.ceil(most(logs)) : 0;
  const bottom = logs.length ? Math.min(top - 1, Math.floor(least(logs))) : -1;
  const marks = ticks(bottom, top, [1, 2, 3, 4, 5, 10, 50], 5);
  const zero = marks[0] - (marks.length > 1 ? marks[1] - marks[0] : 1);
  if (all.some(x => x === 0)) marks.unshift(zero);
  const raised = n => String(n).replace(/[-\d]/g, c => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻");
  return {
    marks,
    label: x => x === zero ? "0" : `10${raised(x)}`,
    place: x => x > 0 ? Math.log10(x) : x === 0 ? zero : NaN,
  };
}

const plots = [
  { svg: element("angles"), legend: element("angle-legend"), curves: angleCurves, axis: evenAxis(angleCurves, DEGREES, 1) },
  { svg: element("error-curves"), legend: element("error-legend"), curves: errorCurves, axis: errorAxis() },
  { svg: element("clearances"), legend: element("clearance-legend"), curves: clearanceCurves, axis: evenAxis(clearanceCurves, DECIMAL, 1e-6) },
];

function plot({ svg, curves, axis }) {
  const width = svg.clientWidth, height = svg.clientHeight;
  const [low, high] = [axis.marks[0], axis.marks.at(-1)];
  const right = width - PAD.right, bottom = height - PAD.bottom;
  const x = time => PAD.left + (duration > 0 ? (time - start) / duration : 0.5) * (right - PAD.left);
  const y = value => bottom - (value - low) / (high - low) * (bottom - PAD.top);

  let labelled = Infinity; // the height of the label below
  const rows = axis.marks.map(mark => {
    const line = `<path class="grid" d="M${PAD.left} ${y(mark)}H${right}"/>`;
    if (labelled - y(mark) < LINE) return line;
    labelled = y(mark);
    return `${line}<text x="${PAD.left - 6}" y="${labelled + 4}" text-anchor="end">${axis.label(mark)}</text>`;
  });
  const columns = ticks(start, start + duration, DECIMAL, 5).filter(time => time >= start && time <= start + duration).map(time =>
    `<path class="grid" d="M${x(time)} ${bottom}v4"/>
     <text x="${x(time)}" y="${bottom + 15}" text-anchor="middle">${time}</text>`);
  const knots = `<path class="knots" d="${knotTimes.map(time => `M${x(time).toFixed(1)} ${bottom}v-5`).join("")}"/>`;
  const phases = scene.phases.map(knot => `<path class="phase" d="M${x(knotTimes[knot])} ${PAD.top}V${bottom}"/>`);
  // A value that is not a number leaves a gap in its curve.
  const paths = curves.map(({ name, colour, dash, group, at }) => {
    let pen = "M";
    const points = at.map((value, k) => {
      const place = axis.place(value);
      if (!Number.isFinite(place)) { pen = "M"; return ""; }
      const step = `${pen}${x(shapeTimes[k]).toFixed(1)} ${y(place).toFixed(1)}`;
      pen = "L";
      return step;
    });
    const selected = view.selected >= 0 && group === groupOf(view.selected) ? " selected" : "";
    return `<path class="curve${selected}" stroke="${colour}" stroke-dasharray="${dash ?? "none"}" d="${points.join("")}"><title>${name}</title></path>`;
  });
  svg.innerHTML = `${rows.join("")}${columns.join("")}${knots}${phases.join("")}${paths.join("")}
    <text x="${right}" y="${height - 4}" text-anchor="end">path time (s)</text>
    <path class="now" d="M0 ${PAD.top}V${bottom}"/>`;
  svg.moveMarker = () => svg.lastElementChild.setAttribute("transform", `translate(${x(timeNow())} 0)`);
  svg.moveMarker();
}

/** Lets the pointer choose the path position on a plot. */
function seekOn(svg) {
  const seek = event => {
    const { left, width } = svg.getBoundingClientRect();
    setPlaying(false);
    setPosition((event.clientX - left - PAD.left) / (width - PAD.left - PAD.right));
  };
  svg.addEventListener("pointerdown", event => { svg.setPointerCapture(event.pointerId); seek(event); });
  svg.addEventListener("pointermove", event => { if (event.buttons) seek(event); });
}

// ---- Words and numbers.

/** Formats a number in a few characters. */
function short(x) {
  if (x === 0 || x === null || !Number.isFinite(x)) return x === 0 ? "0" : "unknown";
  return Math.abs(x) >= 1e-3 && Math.abs(x) < 1e5 ? String(+x.toPrecision(4)) : x.toExponential(2).replace("e", " e");
}

/** Texts that follow the time: each has its element and a function that formats the text. */
const live = [];
function writeLive() {
  for (const { node, say } of live) {
    const text = say();
    if (node.textContent !== text) node.textContent = text;
  }
}

const sample = (colour, dash, width) =>
  `<svg viewBox="0 0 24 8" aria-hidden="true"><path d="M0 4H24" stroke="${colour}" stroke-width="${width}" stroke-dasharray="${dash ?? "none"}"/></svg>`;

/** Writes the legend of a plot: the names of the curves and their values at the current time. */
function writeLegend({ legend, curves }) {
  if (curves.length > MOST_NAMED) {
    legend.innerHTML = `<li>${curves.length} of ${groups} groups, named on hover</li>`;
    return;
  }
  legend.innerHTML = curves.map(curve => `<li>${sample(curve.colour, curve.dash, 2)}${curve.name} <span></span></li>`).join("");
  legend.querySelectorAll("span").forEach((node, i) => live.push({ node, say: () => curves[i].text(curves[i].now()) }));
}
