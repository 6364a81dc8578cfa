// ---- Texts about the path, about the current time, and about the picked hinge.

const cells = (list, ...rows) => {
  list.innerHTML = rows.map(([name, value]) => `<div><dt>${name}</dt><dd>${typeof value === "function" ? "" : value}</dd></div>`).join("");
  list.querySelectorAll("dd").forEach((node, i) => { if (typeof rows[i][1] === "function") live.push({ node, say: rows[i][1] }); });
};
/** Stops the updates of texts whose elements have left the page. */
const forgetLive = () => live.splice(0, live.length, ...live.filter(({ node }) => node.isConnected));

function knotNow() {
  const { low, high, part } = knotPlace;
  return part === 0 ? `${low + 1}` : part === 1 ? `${high + 1}` : `${low + 1}–${high + 1}`;
}

function writeHeader() {
  document.title = scene.title;
  element("title").textContent = scene.title;
  cells(element("counts"),
    ["faces", faces], ["creases", scene.creases], ["groups", groups], ["knots", knotTimes.length],
    ["max deformation", short(scene.max_deformation)], ["max gap", short(scene.max_gap)], ["max closure", short(scene.max_closure)]);
  cells(element("readout"),
    ["time", () => `${timeNow().toFixed(3)} s`], ["of the path", () => `${(100 * position).toFixed(1)} %`],
    ["knot", () => `${knotNow()} of ${knotTimes.length}`],
    ["deformation", () => short(valueNow(shape => shape.deformation))], ["gap", () => short(valueNow(shape => shape.gap))],
    ["closure", () => short(valueNow(shape => shape.closure))]);
  const part = time => (time - start) / (duration || 1);
  element("knots").innerHTML = `<path class="grid" vector-effect="non-scaling-stroke" d="${knotTimes.map(time => `M${part(time)} 0V1`).join("")}"/>
    <path class="phase" vector-effect="non-scaling-stroke" d="${scene.phases.map(knot => `M${part(knotTimes[knot])} -1V5`).join("")}"/>`;
  plots.forEach(writeLegend);
}

/** Writes the legend of the line colours. */
function writeLines() {
  const list = element("lines"), used = LETTERS.filter(letter => edgeLetters.includes(letter));
  const dash = letter => [null, "5 3", "2 2"][(letter.dashes > 0) + (letter.dashes > 6)];
  if (view.colours === "groups") {
    list.innerHTML = Array.from({ length: Math.min(groups, MOST_NAMED) }, (_, group) =>
      `<li>${sample(`rgb(${groupColours[group].map(x => Math.round(255 * x)).join(" ")})`, null, 2)}g${group} <span></span></li>`).join("")
      + (groups > MOST_NAMED ? `<li>and ${groups - MOST_NAMED} more: click a hinge</li>` : "");
    list.querySelectorAll("span").forEach((node, group) => live.push({ node, say: () => `${(DEGREE * groupAngle(group, knotPlace)).toFixed(1)}°` }));
  } else if (view.colours === "deformation") {
    list.innerHTML = `<li>10<sup>${STRAIN[0]}</sup> <i class="ramp"></i> 10<sup>${STRAIN[1]}</sup> of the length</li><li>${sample("var(--worst)", null, 5)}worst: <span></span></li>`;
    const say = () => view.worstEdge < 0 ? "none" : `edge ${view.worstEdge}, ${short(deformation(view.worstEdge))}`;
    live.push({ node: list.querySelector("span"), say });
  } else if (view.colours === "bends") {
    list.innerHTML = `<li>0° <i class="ramp"></i> ${(DEGREE * largestBend).toFixed(1)}°, the largest bend of a panel</li>`;
  } else {
    const colour = letter => view.colours === "paper" && !"BC".includes(letter.letters[0]) ? "--flat" : letter.colour;
    list.innerHTML = used.map(letter => `<li>${sample(`var(${colour(letter)})`, dash(letter), letter.width)}${letter.name}</li>`).join("");
  }
}

function writePair() {
  const pair = scene.worst_pair, box = element("pair");
  box.hidden = !pair;
  if (!pair) return;
  const what = pair.crosses ? `Faces ${pair.faces.join(" and ")} pass through each other` : `Nearest: faces ${pair.faces.join(" and ")}`;
  box.classList.toggle("crosses", pair.crosses);
  box.querySelector("span").textContent = `${what}, ${short(pair.distance)} edges ${pair.crosses ? "deep" : "apart"}, at ${pair.time.toFixed(2)} s`;
  box.querySelector("button").addEventListener("click", () => { setPlaying(false); setTime(pair.time); });
  box.querySelector("input").addEventListener("change", event => { view.pair = event.target.checked; redraw(); });
}

/** Writes the slider of the thickness, and what is proved of plates so thick. */
function writePlates() {
  const box = element("plates");
  box.hidden = !plates || !picture;
  if (box.hidden) return;
  const [slider, shown, told] = ["input", "output", "p"].map(name => box.querySelector(name));
  const set = thickness => {
    view.thickness = thickness;
    if (thickness > 0) setPlates(thickness);
    shown.textContent = `${thickness.toPrecision(4)} ${plates.unit}`;
    const isRefuted = plates.refuted !== null && thickness >= plates.refuted;
    const verdict = thickness === 0 ? "paper" : thickness <= plates.proved ? "proved to fold" : isRefuted ? "too thick" : "not known";
    told.textContent = `${verdict}: ${plates.told}`;
    box.classList.toggle("no", thickness > plates.proved);
    redraw();
  };
  slider.max = 1.02 * thickest;
  slider.value = plates.thickness;
  slider.addEventListener("input", () => set(+slider.value));
  set(plates.thickness);
}

/** Writes what the path leaves undone, with a button for each cause that lights its edges. */
function writeShortfall() {
  const shortfall = scene.shortfall, box = element("shortfall");
  box.hidden = !shortfall;
  if (!shortfall) return;
  box.querySelector("p").textContent = `${shortfall.outcome.replaceAll("_", " ")}: ${(100 * shortfall.reached).toFixed(1)} % of the way`;
  box.querySelector("p + p").hidden = !shortfall.causes.length;
  const buttons = shortfall.causes.map((cause, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = cause.message;
    button.addEventListener("click", () => light(view.cause === i ? -1 : i));
    return button;
  });
  const light = cause => {
    view.cause = cause;
    buttons.forEach((button, i) => button.setAttribute("aria-pressed", i === cause));
    repaint();
  };
  box.querySelector("ul").append(...buttons.map(button => {
    const item = document.createElement("li");
    item.append(button);
    return item;
  }));
  light(view.cause);
}

function writeHinge() {
  const box = element("hinge"), edge = view.selected;
  box.hidden = edge < 0;
  if (edge < 0) return;
  const group = groupOf(edge), sign = Math.sign(scene.turns[edge]), at = groupCurve(group).at.map(value => sign * value);
  cells(box,
    ["hinge", edge], ["letter", `${scene.letters[edge]}, ${edgeLetters[edge].name}`], ["group", `g${group}, ${sign < 0 ? "opposite" : "same"} sign`],
    ["angle", () => `${(sign * DEGREE * groupAngle(group, knotPlace)).toFixed(2)}°`],
    ["rate", () => `${(sign * DEGREE * groupRate(group, knotPlace)).toFixed(2)}°/s`],
    ["on the path", `${least(at).toFixed(1)}° to ${most(at).toFixed(1)}°`]);
}

function say(text) {
  element("message").textContent = text;
  element("message").hidden = false;
}

// ---- The page in motion.

const canvas = element("canvas"), fold = element("fold"), play = element("play"), speed = element("speed"), repeat = element("repeat");
let picture = null, waiting = false, playingSince = null;

/** Schedules one drawing before the next frame; further calls until then have no effect. */
function redraw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    picture?.draw();
    writeLive(); // after drawing, which finds the worst edge
  });
}
function repaint() {
  picture?.repaint();
  redraw();
}

function setPosition(x) {
  position = Math.min(1, Math.max(0, x));
  fold.value = position;
  find(knotTimes, timeNow(), knotPlace);
  find(shapeTimes, timeNow(), shapePlace);
  fold.setAttribute("aria-valuetext", `${(100 * position).toFixed(0)} %, knot ${knotNow()} of ${knotTimes.length}`);
  writeLive();
  plots.forEach(({ svg }) => svg.moveMarker?.());
  redraw();
}
const setTime = time => setPosition(duration > 0 ? (time - start) / duration : 0);

function stepKnot(way) {
  const slack = 1e-9 * duration;
  const next = way > 0 ? knotTimes.find(time => time > timeNow() + slack) : knotTimes.findLast(time => time < timeNow() - slack);
  if (next !== undefined) setTime(next);
}

/** Seconds of one playback at speed 1: the real duration, limited to a time that a viewer can follow. */
const SECONDS = Math.min(15, Math.max(4, duration));

/** Returns the position that playing reaches after some seconds, and the direction from there: 1, -1, or 0 for none. */
function advance(from, seconds, way) {
  const to = from + way * seconds * speed.value / SECONDS;
  if (to >= 0 && to <= 1) return [to, way];
  if (repeat.value === "loop") return [to - Math.floor(to), way];
  if (repeat.value === "back and forth") return [Math.abs(to > 1 ? 2 - to : to) % 1, -way];
  return [to > 1 ? 1 : 0, 0];
}

function setPlaying(on) {
  playingSince = null;
  if (on) {
    const began = performance.now();
    let before = began, way = 1;
    playingSince = began;
    if (position >= 1) setPosition(0);
    requestAnimationFrame(function step(time) {
      if (playingSince !== began) return;
      let to;
      [to, way] = advance(position, Math.max(0, time - before) / 1000, way);
      before = time;
      setPosition(to);
      if (way) requestAnimationFrame(step); else setPlaying(false);
    });
  }
  play.textContent = playingSince === null ? "Play" : "Pause";
}
const togglePlay = () => setPlaying(playingSince === null);

function setColours(colours) {
  view.colours = colours;
  view.worstEdge = -1;
  document.querySelectorAll("#colours button").forEach(button => button.setAttribute("aria-pressed", button.value === colours));
  writeLines();
  forgetLive();
  writeLive();
  repaint();
}

/** Picks a hinge by the number of its edge; -1 picks none. */
function select(edge) {
  view.selected = edge;
  writeHinge();
  forgetLive();
  writeLive();
  plot(plots[0]);
  repaint();
}

/** Returns the next hinge after the one that is picked, or the one before, from the first or the last on. */
function hingeBeside(way) {
  const hinges = scene.turns.flatMap((turn, edge) => turn ? [edge] : []);
  return (way > 0 ? hinges.find(edge => edge > view.selected) : hinges.findLast(edge => edge < view.selected)) ?? hinges.at(way > 0 ? 0 : -1) ?? -1;
}

function saveImage() {
  picture?.draw(); // a canvas keeps its pixels only until the next frame
  canvas.toBlob(blob => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${scene.title}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  });
}

function resetView() {
  resetCamera();
  redraw();
}

/** Magnifies the picture about the point (x, y) of the canvas. */
function zoom(by, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2) {
  by = Math.min(40, Math.max(0.3, camera.zoom * by)) / camera.zoom;
  camera.zoom *= by;
  const still = [2 * x / canvas.clientWidth - 1, 1 - 2 * y / canvas.clientHeight];
  camera.shift = camera.shift.map((shift, i) => still[i] + (shift - still[i]) * by);
  redraw();
}

function pan(dx, dy) {
  camera.shift[0] += 2 * dx / canvas.clientWidth;
  camera.shift[1] -= 2 * dy / canvas.clientHeight;
  redraw();
}

function turn(dx, dy) {
  camera.yaw -= dx * 0.008;
  camera.pitch = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, camera.pitch + dy * 0.008));
  redraw();
}

// ---- Buttons and keys.

const help = element("help");
const KEYS = {
  " ": togglePlay,
  "?": () => help.showModal(),
  "+": () => zoom(1.25), "=": () => zoom(1.25), "-": () => zoom(0.8),
  "r": resetView,
  "n": () => select(hingeBeside(1)), "p": () => select(hingeBeside(-1)),
  "Escape": () => select(-1),
};
COLOURS.forEach((colours, i) => { KEYS[i + 1] = () => setColours(colours); });
/** Keys that change the position on the path; they stop playing. */
const SEEK = {
  ArrowLeft: event => event.shiftKey ? stepKnot(-1) : setPosition(position - 0.01),
  ArrowRight: event => event.shiftKey ? stepKnot(1) : setPosition(position + 0.01),
  Home: () => setPosition(0),
  End: () => setPosition(1),
};
/** Keys that turn the sheet while it has the focus, and the pixels of a drag that would. */
const TURNS = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] };
addEventListener("keydown", event => {
  if (event.ctrlKey || event.altKey || event.metaKey || help.open || event.target.matches("select")) return;
  // A slider other than that of the path has the arrow keys for itself.
  if (event.target.matches("input[type=range]") && event.target !== fold && event.key !== "Escape") return;
  if (event.key.length === 1 && event.key !== " " && !element("letters").checked) return;
  if (event.target === canvas && TURNS[event.key] && !event.shiftKey) {
    turn(...TURNS[event.key]);
    event.preventDefault();
    return;
  }
  const presses = event.key === " " && event.target.matches("button, input[type=checkbox]"); // these elements handle the space bar themselves
  const action = KEYS[event.key], seek = SEEK[event.key];
  if (presses || !action && !seek) return;
  if (seek) setPlaying(false);
  (action ?? seek)(event);
  event.preventDefault();
});

play.addEventListener("click", togglePlay);
fold.addEventListener("input", () => { setPlaying(false); setPosition(+fold.value); });
element("colours").innerHTML = COLOURS.map((colours, i) => `<button type="button" value="${colours}" title="Key ${i + 1}">${colours}</button>`).join("");
element("colours").addEventListener("click", event => { if (event.target.value) setColours(event.target.value); });
element("phases").hidden = !scene.phases.length;
element("phases").insertAdjacentHTML("beforeend", [0, ...scene.phases].map((knot, i) =>
  `<button type="button" value="${knot}" aria-label="Go to the beginning of phase ${i + 1}">${i + 1}</button>`).join(""));
element("phases").addEventListener("click", event => { if (event.target.value) { setPlaying(false); setTime(knotTimes[event.target.value]); } });
element("save").addEventListener("click", saveImage);
element("reset").addEventListener("click", resetView);
element("ask").addEventListener("click", () => help.showModal());

// ---- Pointers: one pointer turns the sheet, or shifts it with the right button; two pinch and shift. A click picks.

const pointers = new Map();
/** Largest movement in pixels between press and release of a click. */
const STILL = 4;
/** The press event that may become a click, or null. */
let pressed = null;
canvas.addEventListener("pointerdown", event => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, event);
  pressed = pointers.size === 1 && event.button === 0 ? event : null;
});
canvas.addEventListener("pointerup", event => {
  if (pressed && Math.hypot(event.offsetX - pressed.offsetX, event.offsetY - pressed.offsetY) <= STILL) select(hingeAt(canvas, event.offsetX, event.offsetY));
});
for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, event => pointers.delete(event.pointerId));
canvas.addEventListener("pointermove", event => {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  const other = [...pointers.values()].find(pointer => pointer.pointerId !== event.pointerId);
  const [dx, dy] = [event.offsetX - before.offsetX, event.offsetY - before.offsetY];
  pointers.set(event.pointerId, event);
  if (other) {
    const apart = pointer => Math.hypot(pointer.offsetX - other.offsetX, pointer.offsetY - other.offsetY) || 1;
    pan(dx / 2, dy / 2);
    zoom(apart(event) / apart(before), (event.offsetX + other.offsetX) / 2, (event.offsetY + other.offsetY) / 2);
  } else if (event.buttons & 2) pan(dx, dy);
  else turn(dx, dy);
});
canvas.addEventListener("contextmenu", event => event.preventDefault());
canvas.addEventListener("wheel", event => { event.preventDefault(); zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY); }, { passive: false });
canvas.addEventListener("dblclick", resetView);

// ---- Beginning.

if (!clearanceKnown) plots.pop().svg.closest("figure").remove();
writeHeader();
writePair();
writeShortfall();
picture = renderer(canvas);
writePlates();
if (!picture) {
  for (const part of ["lines", "colours", "save"]) element(part).hidden = true;
  say("This browser does not offer WebGL 2, which drawing the sheet needs. The curves are complete.");
}
canvas.addEventListener("webglcontextlost", () => say("The browser dropped the drawing. Reload the page to see the sheet again."));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { known.clear(); repaint(); });
new ResizeObserver(redraw).observe(canvas);
plots.forEach(drawn => { new ResizeObserver(() => plot(drawn)).observe(drawn.svg); seekOn(drawn.svg); });
setPosition(0);
setColours(view.colours);

// The sheet folds once by itself as soon as it is in sight, unless the user prefers less motion.
if (picture && duration > 0 && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
  const sight = new IntersectionObserver(entries => {
    if (!entries.some(entry => entry.isIntersecting)) return;
    sight.disconnect();
    if (position === 0) setPlaying(true);
  });
  sight.observe(canvas);
}

/** Interface for tests. */
window.foldpath = {
  errors, view, advance,
  position: () => position, setPosition, setTime,
  playing: () => playingSince !== null,
  camera: () => structuredClone(camera),
  drawn: () => picture?.hash() ?? 0,
  hingeAt: (x, y) => hingeAt(canvas, x, y),
  /** Position of the camera. */
  eye: () => {
    const { low, high, part } = shapePlace, away = fit(canvas.clientWidth / canvas.clientHeight), towards = axesOf(camera)[2];
    return middles[low].map((from, axis) => from + part * (middles[high][axis] - from) + away * towards[axis]);
  },
  /** Fold angle of every edge, radians. */
  angles: () => scene.turns.map(turn => turn && Math.sign(turn) * groupAngle(Math.abs(turn) - 1, knotPlace)),
  vertices: () => { foldAt(timeNow()); return Array.from(folded); },
  /** Middle of an edge, in pixels of the canvas. */
  middleOf: edge => {
    foldAt(timeNow());
    const places = onCanvas(canvas), [a, b] = [3 * scene.edges[2 * edge], 3 * scene.edges[2 * edge + 1]];
    return [0, 1].map(i => (places[a + i] + places[b + i]) / 2);
  },
};
