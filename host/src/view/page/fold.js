"use strict";
// The motion of the crease groups, as in FORMAT.md ("Between knots"), and the folding map, which gives the position of
// every vertex at a time.

const errors = [];
addEventListener("error", event => errors.push(event.message));
addEventListener("unhandledrejection", event => errors.push(String(event.reason)));

const element = id => document.getElementById(id);
const scene = JSON.parse(element("scene").textContent);
const { motion, shapes } = scene;
const groups = motion.groups, edges = scene.letters.length, vertices = scene.vertices.length / 2;
const knotTimes = motion.times, shapeTimes = shapes.map(shape => shape.time);
const start = knotTimes[0], duration = knotTimes.at(-1) - start;

/** Finds a time in a sorted list by bisection: the two entries round it, and the fraction of the way between these. */
function find(times, time, place) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  const span = times[high] - times[low];
  const part = span > 0 ? (time - times[low]) / span : 0, end = Math.round(part);
  // Times are rounded: a time within 1e-9 of an entry counts as that entry.
  place.low = low; place.high = high; place.part = Math.abs(part - end) < 1e-9 ? end : part;
  return place;
}

// ---- Fold angles. Between knots either the angle is a cubic, or c and n are, which are proportional to cosine and
// sine of half the angle. `nodes` has for each group at each knot [angle, its rate] or [c, its rate, n, its rate].

const halves = ["half-angle", "homogeneous"].includes(motion.interpolation);
const nodes = new Float64Array(4 * motion.angles.length);
motion.angles.forEach((angle, i) => {
  const cos = Math.cos(angle / 2), sin = Math.sin(angle / 2), turn = motion.rates[i] / 2;
  if (!halves) nodes.set([angle, motion.rates[i]], 4 * i);
  else if (motion.interpolation === "half-angle") nodes.set([1, 0, sin / cos, turn / (cos * cos)], 4 * i);
  else {
    const [weight, grow] = motion.weights.slice(2 * i, 2 * i + 2);
    nodes.set([weight * cos, grow * cos - weight * sin * turn, weight * sin, grow * sin + weight * cos * turn], 4 * i);
  }
});

/** Value, or slope, of the cubic of a group's first (0) or second (2) number at a place between knots. */
function cubic(group, number, { low, high, part: s }, slope) {
  const a = 4 * (low * groups + group) + number, b = 4 * (high * groups + group) + number;
  const p = nodes[a], q = nodes[b], span = knotTimes[high] - knotTimes[low];
  const straight = motion.interpolation === "linear";
  const m = straight ? q - p : span * nodes[a + 1], n = straight ? q - p : span * nodes[b + 1];
  const square = 3 * (q - p) - 2 * m - n, cube = 2 * (p - q) + m + n;
  return slope ? m + s * (2 * square + 3 * s * cube) : p + s * (m + s * (square + s * cube));
}

/** Fold angle of a group (radians) at a place between knots. */
function groupAngle(group, place) {
  return halves ? 2 * Math.atan2(cubic(group, 2, place), cubic(group, 0, place)) : cubic(group, 0, place);
}

/** Rate of a group (radians per second) at a place between knots. */
function groupRate(group, place) {
  const span = knotTimes[place.high] - knotTimes[place.low];
  if (!(span > 0)) return 0;
  if (!halves) return cubic(group, 0, place, true) / span;
  const c = cubic(group, 0, place), n = cubic(group, 2, place);
  return 2 * (c * cubic(group, 2, place, true) - n * cubic(group, 0, place, true)) / ((c * c + n * n) * span);
}

// ---- The folding map. The pose of a face is a rotation (quaternion w, x, y, z in `turned`), and the images of the
// axes and the origin of the flat sheet (in `frames`).

const faces = scene.faces.length;
const turned = new Float64Array(4 * faces), frames = new Float64Array(9 * faces);
const cosHalf = new Float64Array(groups), sinHalf = new Float64Array(groups);
const folded = new Float64Array(3 * vertices);
const vertexFaces = Int32Array.from(scene.vertex_faces, face => face ?? -1);
const knotPlace = { low: 0, high: 0, part: 0 }, shapePlace = { low: 0, high: 0, part: 0 };

/** Steps of the spanning tree: face, parent face, turn; for each a point of the edge between and its direction. */
const steps = new Int32Array(scene.tree.length / 4 * 3), hinges = new Float64Array(scene.tree.length);
for (let i = 0; 4 * i < scene.tree.length; i++) {
  const [face, parent, edge, from] = scene.tree.slice(4 * i, 4 * i + 4);
  const [a, b] = [from, 1 - from].map(end => 2 * scene.edges[2 * edge + end]);
  const [x, y] = [scene.vertices[b] - scene.vertices[a], scene.vertices[b + 1] - scene.vertices[a + 1]];
  const length = Math.hypot(x, y);
  steps.set([face, parent, scene.turns[edge]], 3 * i);
  hinges.set([scene.vertices[a], scene.vertices[a + 1], x / length, y / length], 4 * i);
}

/** Sets the rotation of a face and moves it so that the point (x, y) of the flat sheet comes to (to_x, to_y, to_z). */
function put(face, w, i, j, k, x, y, to_x, to_y, to_z) {
  const scale = 1 / Math.sqrt(w * w + i * i + j * j + k * k), q = 4 * face, f = 9 * face;
  w *= scale; i *= scale; j *= scale; k *= scale;
  turned[q] = w; turned[q + 1] = i; turned[q + 2] = j; turned[q + 3] = k;
  frames[f] = 1 - 2 * (j * j + k * k); frames[f + 1] = 2 * (i * j + w * k); frames[f + 2] = 2 * (i * k - w * j);
  frames[f + 3] = 2 * (i * j - w * k); frames[f + 4] = 1 - 2 * (i * i + k * k); frames[f + 5] = 2 * (j * k + w * i);
  frames[f + 6] = to_x - frames[f] * x - frames[f + 3] * y;
  frames[f + 7] = to_y - frames[f + 1] * x - frames[f + 4] * y;
  frames[f + 8] = to_z - frames[f + 2] * x - frames[f + 5] * y;
}

/** A coordinate (axis 0 to 2) of the image of the point (x, y) of the flat sheet under the pose of a face. */
const at = (face, x, y, axis) => {
  const f = 9 * face + axis;
  return frames[f] * x + frames[f + 3] * y + frames[f + 6];
};

/** Sets the poses of the root faces, interpolated between the two nearest shapes. */
function putRoots() {
  const { low, high, part } = shapePlace, from = shapes[low].places, to = shapes[high].places;
  for (let r = 0; r < scene.roots.length; r++) {
    const i = 7 * r, pivot = 2 * scene.faces[scene.roots[r]][0][0];
    const dot = from[i] * to[i] + from[i + 1] * to[i + 1] + from[i + 2] * to[i + 2] + from[i + 3] * to[i + 3];
    // A quaternion and its negative are the same rotation.
    const a = 1 - part, b = dot < 0 ? -part : part;
    const mix = (k, b) => a * from[i + k] + b * to[i + k];
    put(scene.roots[r], mix(0, b), mix(1, b), mix(2, b), mix(3, b), scene.vertices[pivot], scene.vertices[pivot + 1],
      mix(4, part), mix(5, part), mix(6, part));
  }
}

/** Folds the sheet at a time of the path: `folded` gets the vertices (x, y, z, x, ...). */
function foldAt(time) {
  find(knotTimes, time, knotPlace);
  find(shapeTimes, time, shapePlace);
  for (let g = 0; g < groups; g++) {
    const c = halves ? cubic(g, 0, knotPlace) : Math.cos(cubic(g, 0, knotPlace) / 2);
    const n = halves ? cubic(g, 2, knotPlace) : Math.sin(cubic(g, 0, knotPlace) / 2);
    const scale = 1 / Math.sqrt(c * c + n * n);
    cosHalf[g] = c * scale; sinHalf[g] = n * scale;
  }
  putRoots();
  for (let step = 0, i = 0; step < steps.length; step += 3, i += 4) {
    const parent = steps[step + 1], turn = steps[step + 2], group = Math.abs(turn) - 1;
    const cos = turn ? cosHalf[group] : 1, sin = turn ? Math.sign(turn) * sinHalf[group] : 0;
    const px = hinges[i], py = hinges[i + 1], bx = sin * hinges[i + 2], by = sin * hinges[i + 3];
    const q = 4 * parent, w = turned[q], x = turned[q + 1], y = turned[q + 2], z = turned[q + 3];
    // The face turns about the edge, whose position is that in the parent face.
    put(steps[step], w * cos - x * bx - y * by, w * bx + x * cos - z * by, w * by + y * cos + z * bx, z * cos + x * by - y * bx,
      px, py, at(parent, px, py, 0), at(parent, px, py, 1), at(parent, px, py, 2));
  }
  for (let v = 0; v < vertices; v++) {
    const face = vertexFaces[v], x = scene.vertices[2 * v], y = scene.vertices[2 * v + 1];
    folded[3 * v] = face < 0 ? x : at(face, x, y, 0);
    folded[3 * v + 1] = face < 0 ? y : at(face, x, y, 1);
    folded[3 * v + 2] = face < 0 ? 0 : at(face, x, y, 2);
  }
}

// ---- Plates: their points at a thickness, in the frame of the flat sheet, and in space.

const { plates } = scene;
const platePoints = plates ? plates.faces.length : 0;
const flatPlates = new Float64Array(3 * platePoints), foldedPlates = new Float64Array(3 * platePoints);

/** Sets the thickness of the plates. Beyond the thickest form that is known, points move on as up to it. */
function setPlates(thickness) {
  const known = plates.thicknesses, above = known.findIndex(it => it >= thickness);
  const high = above < 0 ? known.length - 1 : Math.max(1, above);
  const part = (thickness - known[high - 1]) / (known[high] - known[high - 1]), [from, to] = [plates.points[high - 1], plates.points[high]];
  for (let i = 0; i < flatPlates.length; i++) flatPlates[i] = from[i] + part * (to[i] - from[i]);
}

/** Places the points of the plates on the folded sheet. */
function foldPlates() {
  for (let p = 0; p < platePoints; p++) {
    const face = plates.faces[p], f = 9 * face, [x, y, z] = [flatPlates[3 * p], flatPlates[3 * p + 1], flatPlates[3 * p + 2]];
    for (let axis = 0; axis < 3; axis++) {
      const [j, k] = [(axis + 1) % 3, (axis + 2) % 3];
      const normal = frames[f + j] * frames[f + 3 + k] - frames[f + k] * frames[f + 3 + j];
      foldedPlates[3 * p + axis] = at(face, x, y, axis) + z * normal;
    }
  }
}

// ---- Lengths of the edges, which rigid faces keep.

const flatLengths = Float64Array.from({ length: edges }, (_, e) => {
  const a = 2 * scene.edges[2 * e], b = 2 * scene.edges[2 * e + 1];
  return Math.hypot(scene.vertices[a] - scene.vertices[b], scene.vertices[a + 1] - scene.vertices[b + 1]);
});
const meanLength = flatLengths.reduce((sum, length) => sum + length, 0) / edges;

/** Relative change of length of an edge. */
function deformation(edge) {
  const a = 3 * scene.edges[2 * edge], b = 3 * scene.edges[2 * edge + 1];
  const x = folded[a] - folded[b], y = folded[a + 1] - folded[b + 1], z = folded[a + 2] - folded[b + 2];
  return Math.abs(Math.sqrt(x * x + y * y + z * z) / flatLengths[edge] - 1);
}

// ---- Extent of the sheet: for each shape the middle of its bounding box; over all shapes the radius of a ball round
// these middles, and the reach along the three axes of the first view.

const START = { yaw: -1.3, pitch: 0.8 };
const axesOf = ({ yaw, pitch }) => {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return [[-sy, cy, 0], [-sp * cy, -sp * sy, cp], [cp * cy, cp * sy, sp]]; // right, up, towards the camera
};
const middles = [], reaches = [0, 0, 0];
let radius = 0;
shapes.forEach(shape => {
  foldAt(shape.time);
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < folded.length; i++) {
    low[i % 3] = Math.min(low[i % 3], folded[i]);
    high[i % 3] = Math.max(high[i % 3], folded[i]);
  }
  const [x, y, z] = low.map((low, axis) => (low + high[axis]) / 2), axes = axesOf(START);
  for (let i = 0; i < folded.length; i += 3) {
    const dx = folded[i] - x, dy = folded[i + 1] - y, dz = folded[i + 2] - z;
    radius = Math.max(radius, Math.hypot(dx, dy, dz));
    axes.forEach((axis, k) => { reaches[k] = Math.max(reaches[k], Math.abs(axis[0] * dx + axis[1] * dy + axis[2] * dz)); });
  }
  middles.push([x, y, z]);
});
const thickest = plates ? Math.max(plates.refuted ?? plates.proved, plates.thickness) : 0;
radius += thickest;
reaches.forEach((reach, axis) => { reaches[axis] = reach + thickest / 2; });
radius ||= 1;
