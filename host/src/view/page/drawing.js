// ---- Camera: it turns about the middle of the sheet. Zooming magnifies the picture and does not move the camera, so
// that the camera never gets inside the paper.

const FOCAL = 5;
const camera = {};
const resetCamera = () => Object.assign(camera, START, { zoom: 1, shift: [0, 0] });
resetCamera();

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Distance of the camera from which all shapes fit into the picture. */
const fit = aspect => Math.max(1.1 * radius, reaches[2] + 1.12 * FOCAL * Math.max(reaches[0] / aspect, reaches[1]));

/** Matrix from world to clip space, by columns. */
function projection(aspect) {
  const { low, high, part } = shapePlace, distance = fit(aspect);
  const centre = middles[low].map((from, axis) => from + part * (middles[high][axis] - from));
  const [right, up, towards] = axesOf(camera);
  const w = [...towards.map(x => -x), distance + dot(towards, centre)];
  const row = (axis, scale, shift) => [...axis, -dot(axis, centre)].map((x, i) => scale * x + shift * w[i]);
  const near = distance - 1.05 * radius, far = distance + 1.05 * radius;
  const z = w.map(x => x * (far + near) / (far - near));
  z[3] -= 2 * far * near / (far - near);
  const scale = FOCAL * camera.zoom;
  const rows = [row(right, scale / aspect, camera.shift[0]), row(up, scale, camera.shift[1]), z, w];
  return [0, 1, 2, 3].flatMap(column => rows.map(r => r[column]));
}

// ---- Colours.

const colourOf = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
/** Cache of the colours of the page as numbers, cleared when the page changes between light and dark. */
const known = new Map();
function rgb(name) {
  if (!known.has(name)) known.set(name, [1, 3, 5].map(i => parseInt(colourOf(name).slice(i, i + 2), 16) / 255));
  return known.get(name);
}

/** Hue of a crease group: evenly spread for up to 12 groups, else far apart for groups with neighbouring numbers. */
const hue = group => (205 + (groups <= 12 ? 360 / groups : 137.5) * group) % 360;
function hslToRgb(h, s, l) {
  const part = n => { const k = (n + h / 30) % 12; return l - s * Math.min(l, 1 - l) * Math.max(-1, Math.min(k - 3, 9 - k, 1)); };
  return [part(0), part(8), part(4)];
}

const groupColours = Array.from({ length: groups }, (_, group) => hslToRgb(hue(group), 0.75, 0.4));

/** Line styles by FOLD letter. `dashes` is the number of dashes of a mean edge, to tell letters without colour. */
const LETTERS = [
  { letters: "M", name: "mountain", colour: "--mountain", width: 2, dashes: 0 },
  { letters: "V", name: "valley", colour: "--valley", width: 2, dashes: 4 },
  { letters: "U", name: "free", colour: "--free", width: 2, dashes: 9 },
  { letters: "FJ", name: "flat", colour: "--flat", width: 1, dashes: 0 },
  { letters: "BC", name: "boundary", colour: "--boundary", width: 2, dashes: 0 },
];
const letterOf = edge => LETTERS.find(({ letters }) => letters.includes(scene.letters[edge]));
const edgeLetters = Array.from({ length: edges }, (_, edge) => letterOf(edge));

/** Edges about which panels bend, and the largest of their angles in any shape, radians. */
const bends = Array.from({ length: edges }, (_, edge) => edge).filter(edge => scene.letters[edge] === "J" && scene.turns[edge]);
const largestBend = bends.reduce((most, edge) => shapeTimes.reduce((most, time) =>
  Math.max(most, Math.abs(groupAngle(Math.abs(scene.turns[edge]) - 1, find(knotTimes, time, {})))), most), 0);

/** Meanings that the colours of lines may have, in the order of the keys 1 to 5; bends only where panels bend. */
const COLOURS = ["paper", "groups", "letters", "deformation", ...largestBend > 0 ? ["bends"] : []];
/** Colours that change along the path. */
const CHANGING = ["deformation", "bends"];
/** Powers of ten of the deformations that have the first and the last colour. */
const STRAIN = [-9, -2];
/** Width in pixels from which a line stands out: it keeps its width where other lines get thinner. */
const STANDS_OUT = 3;

/** `cause` is the number of the cause whose edges are lit, or -1. */
const view = { thickness: plates?.thickness ?? 0, colours: "letters", selected: -1, pair: true, worstEdge: -1, cause: scene.shortfall?.causes.length ? 0 : -1 };
const groupOf = edge => Math.abs(scene.turns[edge]) - 1;
const lineStyles = new Uint8Array(4 * edges); // red, green, blue, width in sixteenths of a pixel

function paintLines() {
  const palette = Object.fromEntries([...LETTERS.map(letter => letter.colour), "--selected", "--worst", "--crossing"].map(name => [name, rgb(name)]));
  const [cold, hot] = [rgb("--cold"), rgb("--hot")];
  const set = (edge, [r, g, b], width) => {
    const i = 4 * edge;
    lineStyles[i] = 255 * r; lineStyles[i + 1] = 255 * g; lineStyles[i + 2] = 255 * b; lineStyles[i + 3] = 16 * width;
  };
  const mixed = [0, 0, 0];
  const mix = part => { for (let i = 0; i < 3; i++) mixed[i] = cold[i] + part * (hot[i] - cold[i]); return mixed; };
  let worst = 0;
  view.worstEdge = -1;
  for (let edge = 0; edge < edges; edge++) {
    const letter = edgeLetters[edge], group = groupOf(edge);
    if (view.colours === "deformation") {
      const value = deformation(edge), part = Math.min(1, Math.max(0, (Math.log10(value) - STRAIN[0]) / (STRAIN[1] - STRAIN[0])));
      set(edge, mix(part), 2);
      if (value > worst) { worst = value; view.worstEdge = edge; }
    } else if (group < 0 || view.colours === "letters") set(edge, palette[letter.colour], letter.width);
    else if (view.colours === "groups") set(edge, groupColours[group], 2);
    else set(edge, palette["--flat"], 1);
  }
  if (view.colours === "bends") for (const edge of bends) set(edge, mix(Math.abs(groupAngle(groupOf(edge), knotPlace)) / largestBend), 4);
  if (view.cause >= 0) for (const edge of scene.shortfall.causes[view.cause].edges) set(edge, palette["--crossing"], 5);
  if (view.worstEdge >= 0) set(view.worstEdge, palette["--worst"], 5);
  if (view.selected >= 0) {
    const group = groupOf(view.selected);
    for (let edge = 0; edge < edges; edge++) {
      if (groupOf(edge) === group) set(edge, palette["--selected"], 3.5);
      else if (groupOf(edge) >= 0 && !CHANGING.includes(view.colours)) set(edge, palette["--flat"], 1);
    }
    set(view.selected, palette["--selected"], 7);
  }
}

// ---- Drawing. All vertex positions are in one texture, in which the shaders look them up by index.

const LOOK_UP = `#version 300 es
precision highp float;
uniform mat4 camera;
uniform highp sampler2D positions;
vec3 at(int i) {
  int width = textureSize(positions, 0).x;
  return texelFetch(positions, ivec2(i % width, i / width), 0).xyz;
}`;
const FACE_VERTEX = `${LOOK_UP}
out vec3 place;
void main() {
  place = at(gl_VertexID);
  gl_Position = camera * vec4(place, 1);
}`;
// The normal comes from the derivatives between neighbouring pixels: flat shading without normals in memory.
const FACE_PIXEL = `#version 300 es
precision highp float;
uniform vec3 front, back, light;
in vec3 place;
out vec4 colour;
void main() {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  colour = vec4((gl_FrontFacing ? front : back) * (0.66 + 0.34 * dot(normal, light)), 1);
}`;
// A line is a strip of four corners that is `width` pixels wide.
const LINE_VERTEX = `${LOOK_UP}
uniform vec2 pixels;
uniform vec3 widths; // pixels of the picture in one of the page, thinning, and where a line stands out
in ivec3 edge; // both ends and the number of dashes
in vec4 style; // colour, and width in parts of 16 pixels
out float along;
flat out float dashes;
flat out vec3 ink;
void main() {
  vec4 a = camera * vec4(at(edge.x), 1), b = camera * vec4(at(edge.y), 1);
  vec2 way = (b.xy / b.w - a.xy / a.w) * pixels;
  way = dot(way, way) > 0.0 ? normalize(way) : vec2(1, 0);
  float end = float(gl_VertexID & 1), side = float(gl_VertexID & 2) - 1.0, width = 255.0 / 16.0 * style.a;
  width *= widths.x * (width > widths.z ? 1.0 : widths.y);
  vec2 out_by = vec2(-way.y, way.x) * side + way * (2.0 * end - 1.0) * 0.5;
  gl_Position = mix(a, b, end);
  gl_Position.xy += out_by * width / pixels * gl_Position.w;
  along = end;
  dashes = float(edge.z);
  ink = style.rgb;
}`;
const LINE_PIXEL = `#version 300 es
precision highp float;
in float along;
flat in float dashes;
flat in vec3 ink;
out vec4 colour;
void main() {
  if (dashes > 0.0 && fract(along * dashes + 0.3) > 0.6) discard;
  colour = vec4(ink, 1);
}`;

function program(gl, vertex, pixel) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, pixel]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.bindAttribLocation(made, 0, "edge");
  gl.bindAttribLocation(made, 1, "style");
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) {
    throw new Error(gl.getAttachedShaders(made).map(shader => gl.getShaderInfoLog(shader)).join("\n"));
  }
  const places = {};
  return { made, at: name => places[name] ??= gl.getUniformLocation(made, name) };
}

function renderer(canvas) {
  const gl = canvas.getContext("webgl2", { alpha: false });
  if (!gl) return null;

  const faceProgram = program(gl, FACE_VERTEX, FACE_PIXEL);
  const lineProgram = program(gl, LINE_VERTEX, LINE_PIXEL);

  const places = vertices + platePoints, width = Math.min(1024, places), height = Math.ceil(places / width);
  const texels = new Float32Array(3 * width * height);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGB32F, width, height);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);

  const faceArray = gl.createVertexArray(), faceCorners = scene.faces.flat(2);
  const corners = faceCorners.concat(plates ? plates.triangles.map(point => vertices + point) : []);
  gl.bindVertexArray(faceArray);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(corners), gl.STATIC_DRAW);
  /** Index of each face's first corner in `corners`. */
  const begins = [0];
  for (const face of scene.faces) begins.push(begins.at(-1) + 3 * face.length);
  /** First corner and number of corners of what is drawn of a face: of its plate, if plates are drawn. */
  const partOf = face => {
    if (!view.thickness) return [begins[face], begins[face + 1] - begins[face]];
    const plate = plates.of_face[face], [from, to] = [plates.ends[plate - 1] ?? 0, plates.ends[plate]];
    return [faceCorners.length + 3 * from, 3 * (to - from)];
  };

  const lineArray = gl.createVertexArray();
  gl.bindVertexArray(lineArray);
  const dashes = edge => edgeLetters[edge].dashes && Math.max(1, Math.round(edgeLetters[edge].dashes * flatLengths[edge] / meanLength));
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, Int32Array.from({ length: 3 * edges }, (_, i) => {
    const edge = Math.floor(i / 3), part = i % 3;
    return part < 2 ? scene.edges[2 * edge + part] : dashes(edge);
  }), gl.STATIC_DRAW);
  gl.vertexAttribIPointer(0, 3, gl.INT, 0, 0);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer()); // stays bound, as line styles are written to it later
  gl.bufferData(gl.ARRAY_BUFFER, lineStyles, gl.DYNAMIC_DRAW);
  gl.vertexAttribPointer(1, 4, gl.UNSIGNED_BYTE, true, 0, 0);
  for (const attribute of [0, 1]) {
    gl.enableVertexAttribArray(attribute);
    gl.vertexAttribDivisor(attribute, 1);
  }
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  let painted = false;

  function drawFaces(front, back, first, count) {
    gl.uniform3fv(faceProgram.at("front"), front);
    gl.uniform3fv(faceProgram.at("back"), back);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * first);
  }

  function draw() {
    // The size is set only if it differs, because setting it makes a new buffer. A hidden canvas has the size 0.
    for (const [side, length] of [["width", canvas.clientWidth], ["height", canvas.clientHeight]]) {
      const pixels = Math.max(1, Math.round(length * devicePixelRatio));
      if (canvas[side] !== pixels) canvas[side] = pixels;
    }
    const aspect = canvas.width / canvas.height;
    foldAt(timeNow());
    const matrix = projection(aspect);
    texels.set(folded);
    if (view.thickness) {
      foldPlates();
      texels.set(foldedPlates, 3 * vertices);
    }
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGB, gl.FLOAT, texels);
    if (!painted || CHANGING.includes(view.colours)) {
      paintLines();
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, lineStyles);
      painted = true;
    }
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...rgb("--table"), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);

    // The light comes over the viewer's left shoulder for every orientation of the sheet.
    const [right, up, towards] = axesOf(camera);
    const light = [0, 1, 2].map(i => -0.55 * right[i] + 0.45 * up[i] + 0.7 * towards[i]);
    gl.useProgram(faceProgram.made);
    gl.uniformMatrix4fv(faceProgram.at("camera"), false, matrix);
    gl.uniform3fv(faceProgram.at("light"), light);
    gl.bindVertexArray(faceArray);
    // Faces are pushed back by their change of depth across half the width of a line, so that lines lie on them.
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1.5 * devicePixelRatio, 4);
    // Plates are closed, so that their triangles are seen from outside.
    if (view.thickness) drawFaces(rgb("--front"), rgb("--front"), faceCorners.length, corners.length - faceCorners.length);
    else drawFaces(rgb("--front"), rgb("--back"), 0, faceCorners.length);
    if (view.pair && scene.worst_pair) {
      const colour = rgb(scene.worst_pair.crosses ? "--crossing" : "--nearest");
      for (const face of scene.worst_pair.faces) drawFaces(colour, colour, ...partOf(face));
    }
    gl.disable(gl.POLYGON_OFFSET_FILL);

    // Lines get thinner when creases are close to each other in the picture, as full lines would hide the paper.
    const edgePixels = meanLength * FOCAL * camera.zoom / fit(aspect) * canvas.clientHeight / 2;
    const thinning = Math.min(1, Math.max(0.2, edgePixels / 40));
    gl.useProgram(lineProgram.made);
    gl.uniformMatrix4fv(lineProgram.at("camera"), false, matrix);
    gl.uniform2f(lineProgram.at("pixels"), canvas.width, canvas.height);
    gl.uniform3f(lineProgram.at("widths"), devicePixelRatio, thinning, STANDS_OUT);
    gl.bindVertexArray(lineArray);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, edges);
  }

  /** Draws the picture and returns a hash of its pixels. */
  function hash() {
    draw();
    const pixels = new Uint32Array(canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.buffer));
    return pixels.reduce((sum, pixel) => Math.imul(sum ^ pixel, 16777619) ^ (sum >>> 15), 0);
  }
  return { draw, hash, repaint() { painted = false; } };
}

// ---- Picking.

/** Largest distance in pixels of a click from the hinge that it picks. */
const REACH = 10;
/** Depth by which a hinge behind a face can still be picked, as a fraction of the range: its own faces touch it. */
const BEHIND = 2e-3;

/** Position of each vertex on the canvas: pixels to the right, pixels downwards, and depth. */
function onCanvas(canvas) {
  const m = projection(canvas.clientWidth / canvas.clientHeight), places = new Float64Array(3 * vertices);
  for (let i = 0; i < folded.length; i += 3) {
    const [x, y, z, w] = [0, 1, 2, 3].map(row => m[row] * folded[i] + m[4 + row] * folded[i + 1] + m[8 + row] * folded[i + 2] + m[12 + row]);
    places.set([(1 + x / w) / 2 * canvas.clientWidth, (1 - y / w) / 2 * canvas.clientHeight, z / w], i);
  }
  return places;
}

/** Smallest depth of any face at a pixel; infinite without a face. */
function depthAt(places, x, y) {
  let least = Infinity;
  for (const face of scene.faces) for (const [a, b, c] of face) {
    const [ax, ay, bx, by, cx, cy] = [a, b, c].flatMap(v => [places[3 * v] - x, places[3 * v + 1] - y]);
    const parts = [bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx], area = parts[0] + parts[1] + parts[2];
    if (area === 0 || parts.some(part => part * area < 0)) continue;
    least = Math.min(least, (parts[0] * places[3 * a + 2] + parts[1] * places[3 * b + 2] + parts[2] * places[3 * c + 2]) / area);
  }
  return least;
}

/** Returns the edge of the nearest hinge at a pixel of the canvas that no face hides, or -1. */
function hingeAt(canvas, x, y) {
  foldAt(timeNow());
  const places = onCanvas(canvas), near = [];
  for (let edge = 0; edge < edges; edge++) {
    if (!scene.turns[edge]) continue;
    const [a, b] = [3 * scene.edges[2 * edge], 3 * scene.edges[2 * edge + 1]];
    const dx = places[b] - places[a], dy = places[b + 1] - places[a + 1], square = dx * dx + dy * dy;
    const s = square > 0 ? Math.min(1, Math.max(0, ((x - places[a]) * dx + (y - places[a + 1]) * dy) / square)) : 0;
    const [px, py, depth] = [0, 1, 2].map(i => places[a + i] + s * (places[b + i] - places[a + i]));
    const distance = Math.hypot(px - x, py - y);
    if (distance <= REACH) near.push({ edge, distance, px, py, depth });
  }
  near.sort((a, b) => a.distance - b.distance);
  return near.find(({ px, py, depth }) => depth <= depthAt(places, px, py) + BEHIND)?.edge ?? -1;
}
