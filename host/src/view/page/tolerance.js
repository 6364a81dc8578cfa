// ---- The play of the hinges, on a page that was made for an error of the sheet. Functions of the page are replaced by others that
// call them, so that pages without play have none of this.

const { tolerance } = scene;
/** Colours by the play that hinges need: in the worst case, and as the root mean square of random errors. */
const PLAYS = { "worst play": hinge => hinge.worst, "expected play": hinge => hinge.expected };
/** Number of hinges and vertices that are listed, and of vertices that are marked. */
const LISTED = 8;
const playOf = new Map(tolerance.hinges.map(hinge => [hinge.edge, hinge]));
const mostPlay = of => most([0, ...tolerance.hinges.map(of)]);
const cuttableEdges = new Set(tolerance.redundant);
const ranking = tolerance.hinges.filter(hinge => hinge.worst > 0).slice(0, LISTED);
const ranked = tolerance.vertices.filter(vertex => vertex.cost > 0).slice(0, LISTED);

COLOURS.push(...Object.keys(PLAYS));
view.colours = COLOURS.at(-2);
/** `cuttable`: hinges that may be cut have a colour of their own; `vertex`: the vertex that is picked, or -1. */
Object.assign(view, { cuttable: tolerance.redundant.length > 0, vertex: -1 });

const inLengths = x => `${short(x)} ${tolerance.unit || "units"}`;
/** A play as a turn, and as the shift that counts as much. */
const playText = play => `${short(DEGREE * play / tolerance.radian)}° or ${inLengths(play)}`;

const paintWithoutPlay = paintLines;
paintLines = () => {
  paintWithoutPlay();
  const of = PLAYS[view.colours];
  if (!of) return;
  const [cold, hot, cut] = ["--cold", "--hot", "--valley"].map(rgb), all = mostPlay(of);
  for (const hinge of tolerance.hinges) {
    if (hinge.edge === view.selected) continue;
    const part = all > 0 ? of(hinge) / all : 0;
    const colour = view.cuttable && cuttableEdges.has(hinge.edge) ? cut : cold.map((from, i) => from + part * (hot[i] - from));
    lineStyles.set([...colour.map(x => 255 * x), 16 * (1 + 2 * part)], 4 * hinge.edge);
  }
};

const writeLinesWithoutPlay = writeLines;
writeLines = () => {
  writeLinesWithoutPlay();
  const of = PLAYS[view.colours];
  if (of) element("lines").innerHTML = `<li>0 <i class="ramp"></i> ${playText(mostPlay(of))}, ${view.colours}; broad lines need more</li>
    ${view.cuttable ? `<li>${sample("var(--valley)", null, 3)}may be cut, or given any play</li>` : ""}
    <li>${sample("var(--worst)", "6 99", 8)}vertices whose error costs most</li>`;
};

const writeHingeWithoutPlay = writeHinge;
writeHinge = () => {
  writeHingeWithoutPlay();
  const hinge = playOf.get(view.selected);
  if (!hinge) return;
  const rows = [["worst play", `${playText(hinge.worst)}, ${hinge.kind}, at ${hinge.at.toFixed(3)} s`], ["expected play", playText(hinge.expected)]];
  if (cuttableEdges.has(hinge.edge)) rows.push(["may be", "cut, or given any play"]);
  element("hinge").insertAdjacentHTML("beforeend", rows.map(([name, value]) => `<div><dt>${name}</dt><dd>${value}</dd></div>`).join(""));
};

// Marks of vertices are bars: lines of no length, drawn after the others by their program. They shine through the paper.
const rendererWithoutMarks = renderer;
renderer = canvas => {
  const sheet = rendererWithoutMarks(canvas), gl = sheet && canvas.getContext("webgl2");
  if (!sheet) return null;
  const usual = gl.getParameter(gl.ARRAY_BUFFER_BINDING), marks = gl.createVertexArray(), styles = gl.createBuffer();
  gl.bindVertexArray(marks);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, Int32Array.from(ranked.flatMap(({ vertex }) => [vertex, vertex, 0])), gl.STATIC_DRAW);
  gl.vertexAttribIPointer(0, 3, gl.INT, 0, 0);
  gl.bindBuffer(gl.ARRAY_BUFFER, styles);
  gl.vertexAttribPointer(1, 4, gl.UNSIGNED_BYTE, true, 0, 0);
  for (const attribute of [0, 1]) {
    gl.enableVertexAttribArray(attribute);
    gl.vertexAttribDivisor(attribute, 1);
  }
  gl.bindBuffer(gl.ARRAY_BUFFER, usual);
  const draw = () => {
    sheet.draw();
    if (!PLAYS[view.colours]) return;
    const style = ({ vertex, cost }) => {
      const picked = vertex === view.vertex, width = picked ? 15.9 : 8 + 5 * cost / ranked[0].cost;
      return [...rgb(picked ? "--selected" : "--worst").map(x => 255 * x), 16 * width];
    };
    gl.bindVertexArray(marks);
    gl.bindBuffer(gl.ARRAY_BUFFER, styles);
    gl.bufferData(gl.ARRAY_BUFFER, Uint8Array.from(ranked.flatMap(style)), gl.DYNAMIC_DRAW);
    gl.bindBuffer(gl.ARRAY_BUFFER, usual);
    gl.disable(gl.DEPTH_TEST);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, ranked.length);
    gl.enable(gl.DEPTH_TEST);
  };
  return { ...sheet, draw };
};

element("readout").insertAdjacentHTML("afterend", `<section id="tolerance" aria-label="Play of the hinges"><p></p>
  <h2>Hinges by their worst play</h2><ol></ol><h2>Vertices by the play that their error alone needs</h2><ol></ol>
  <button type="button"></button></section>`);
{
  const box = element("tolerance"), [hinges, vertices] = box.querySelectorAll("ol"), cuttable = box.querySelector("section > button");
  const button = (list, text, press) => {
    const item = list.appendChild(document.createElement("li")).appendChild(document.createElement("button"));
    item.type = "button";
    item.textContent = text;
    item.addEventListener("click", () => press(item));
  };
  box.querySelector("p").textContent = ranking.length === 0 ? "No error needs play." :
    `Errors of up to ${inLengths(tolerance.error)} in each coordinate of each vertex need play of up to ${playText(mostPlay(hinge => hinge.worst))}, `
    + `to first order and from the moment that a hinge is folded by ${tolerance.from}°. A turn by a radian counts as much as a shift by ${inLengths(tolerance.radian)}.`
    + (DEGREE * mostPlay(hinge => hinge.worst) > tolerance.from * tolerance.radian ? " So much play is beyond first order: read it as too much, not as a figure." : "");
  for (const { edge, worst, kind, at } of ranking) {
    button(hinges, `hinge ${edge}: ${playText(worst)}, ${kind}, at ${at.toFixed(3)} s`, () => {
      setPlaying(false);
      setTime(at);
      select(edge);
    });
  }
  for (const { vertex, cost } of ranked) {
    button(vertices, `vertex ${vertex}: ${playText(cost)}`, pressed => {
      view.vertex = view.vertex === vertex ? -1 : vertex;
      vertices.querySelectorAll("button").forEach(item => item.setAttribute("aria-pressed", item === pressed && view.vertex === vertex));
      repaint();
    });
  }
  for (const title of box.querySelectorAll("h2")) title.hidden = ranking.length === 0;
  const count = tolerance.redundant.length;
  cuttable.textContent = `${count} ${count === 1 ? "hinge that" : "hinges of which each"} may be cut or given any play`;
  cuttable.hidden = count === 0;
  cuttable.setAttribute("aria-pressed", view.cuttable);
  cuttable.addEventListener("click", () => {
    view.cuttable = !view.cuttable;
    cuttable.setAttribute("aria-pressed", view.cuttable);
    setColours(view.colours);
  });
  const keys = COLOURS.length;
  element("letters").closest("dialog").querySelector("dl").insertAdjacentHTML("beforeend",
    `<div><dt>${keys - 1} ${keys}</dt><dd>colours: ${Object.keys(PLAYS).join(", ")}</dd></div>`);
}
