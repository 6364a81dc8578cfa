"use strict";
// The page: opens a file, plans it in a worker, and shows the answer. The picture is the page that `foldpath view` writes.

const element = id => document.getElementById(id);
const [status, progress, cancel, options] = ["status", "progress", "cancel", "options"].map(element);

// ---- The worker. To cancel is to end it and to begin another.

/** The module and its worker, if this page has them in itself, as text. */
const inlined = { module: element("module"), worker: element("worker") };
let worker, calls = 0, waiting = new Map();

/** The module, compiled once for all workers. */
const compiled = inlined.module
  ? WebAssembly.compile(Uint8Array.from(atob(inlined.module.textContent.trim()), c => c.charCodeAt(0)))
  : WebAssembly.compileStreaming(fetch("foldpath_bg.wasm"));
compiled.catch(error => say(`The module does not load (${error.message}). From a disk, open foldpath.html.`, true));

function begin() {
  const source = inlined.worker
    ? URL.createObjectURL(new Blob([inlined.worker.textContent], { type: "text/javascript" }))
    : "worker.js";
  worker = new Worker(source);
  const begun = worker;
  compiled.then(module => begun.postMessage({ module }), () => {});
  worker.onmessage = ({ data: { id, told, result, error } }) => {
    const call = waiting.get(id);
    if (!call) return;
    if (told) return call.told?.(told);
    waiting.delete(id);
    if (error === undefined) call.resolve(result); else call.reject(new Error(error));
  };
  // The module stops for good where it ends by itself.
  worker.onerror = event => end(`The module has stopped: ${event.message}`);
}

/** Ends the worker, and every call that waits for it, and begins another. */
function end(why) {
  worker.terminate();
  const ended = [...waiting.values()];
  waiting.clear();
  begin();
  ended.forEach(call => call.reject(new Error(why)));
}

function ask(call, more = {}, told) {
  return new Promise((resolve, reject) => {
    waiting.set(++calls, { resolve, reject, told });
    worker.postMessage({ id: calls, call, ...more });
  });
}

// ---- The pattern and its plan.

/** The file that is open: { name, bytes }, and the window that sent it, if one did. */
let opened = null;
/** Number of the plan that is asked for last: answers to others are late. */
let latest = 0;

/** The options of the form by their names on the command line, without those that are left as they are. */
function chosen() {
  const all = [...new FormData(options)].filter(([, value]) => value.trim() !== "");
  return Object.fromEntries(all.map(([name, value]) => [name, name === "crease" ? value.trim().split(/[\s,]+/) : value.trim()]));
}

function say(text, isNo = false) {
  status.textContent = text;
  status.classList.toggle("no", isNo);
}

/** Says `true` of a FOLD file that has a path. */
function isPath({ name, bytes }) {
  if (!/\.fold$/i.test(name)) return false;
  try {
    return JSON.parse(new TextDecoder().decode(bytes)).file_classes?.includes("animation") ?? false;
  } catch {
    return false; // the module says what is wrong
  }
}

async function answer() {
  if (!opened) return;
  if (waiting.size) end("superseded");
  const number = ++latest, file = opened, call = isPath(file) ? "check" : "plan";
  say(`${file.name}: working`);
  element("answer").hidden = true;
  cancel.hidden = progress.hidden = false;
  progress.removeAttribute("value");
  const told = ({ stage, part }) => {
    say(`${file.name}: ${stage}`);
    if (part === undefined) progress.removeAttribute("value"); else progress.value = part;
  };
  try {
    const { json, page } = await ask(call, { name: file.name, bytes: file.bytes, options: call === "plan" ? chosen() : {} }, told);
    if (number !== latest) return;
    show(file, JSON.parse(json), page, call);
    file.reply?.({ outcome: JSON.parse(json).outcome, answer: JSON.parse(json) });
  } catch (error) {
    if (number !== latest) return;
    say(error.message, true);
    file.reply?.({ outcome: null, error: error.message });
  } finally {
    if (number === latest) cancel.hidden = progress.hidden = true;
  }
}

const short = x => typeof x === "number" ? +x.toPrecision(4) : x;

function show(file, json, page, call) {
  const yes = ["planned", "holds"].includes(json.outcome);
  say(`${file.name}: ${json.outcome.replaceAll("_", " ")}${json.reason ? `: ${json.reason}` : ""}`, !yes);
  const rows = [
    ["outcome", json.outcome], ["reached", json.reached === undefined ? null : `${short(100 * json.reached)} %`],
    ["creases", json.creases], ["crease groups", json.groups], ["knots", json.knots],
    ["certified deformation", json.certified_deformation], ["deformation", json.max_deformation],
    ["largest bend", json.max_bend ? `${short(json.max_bend)}°` : null], ["clearance", json.min_clearance],
    ["time", json.time && `${short(1e3 * json.time.total)} ms`],
  ];
  const list = element("answer").querySelector("dl");
  list.replaceChildren(...rows.filter(([, value]) => value !== null && value !== undefined).flatMap(([name, value]) => {
    const [term, detail] = ["dt", "dd"].map(tag => document.createElement(tag));
    term.textContent = name;
    detail.textContent = short(value);
    return [term, detail];
  }));
  element("notes").replaceChildren(...(json.notes ?? json.undecided ?? []).map(note => {
    const item = document.createElement("li");
    item.textContent = note;
    return item;
  }));
  element("files").hidden = call !== "plan";
  element("answer").hidden = false;
  element("view").srcdoc = page;
}

function openPattern(name, bytes, reply) {
  opened = { name, bytes, reply };
  return answer();
}

async function openFile(file) {
  if (file) await openPattern(file.name, new Uint8Array(await file.arrayBuffer()));
}

// ---- Files, buttons and the form.

const ENDINGS = { fold: ".path.fold", glb: ".glb", csv: ".csv", traj: ".traj", pattern: ".svg", curves: ".curves.svg" };

async function download(format) {
  try {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([await ask("file", { format })]));
    link.download = opened.name.replace(/\.[^.]*$/, "") + ENDINGS[format];
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  } catch (error) {
    say(error.message, true);
  }
}

addEventListener("dragover", event => { event.preventDefault(); document.body.classList.add("over"); });
addEventListener("dragleave", () => document.body.classList.remove("over"));
addEventListener("drop", event => {
  event.preventDefault();
  document.body.classList.remove("over");
  openFile(event.dataTransfer.files[0]);
});
element("file").addEventListener("change", event => openFile(event.target.files[0]));
element("example").addEventListener("click", async () => openPattern("miura-11x11.fold", new TextEncoder().encode(await ask("generate", { family: { family: "miura", rows: 11, cols: 11 } }))));
element("files").addEventListener("click", event => { if (event.target.value) download(event.target.value); });
options.addEventListener("change", answer);
options.addEventListener("submit", event => event.preventDefault());
cancel.addEventListener("click", () => end("cancelled"));

// ---- Other windows. They send a pattern as to Origami Simulator, { op: "importFold", fold } or { op: "importSVG", svg,
// filename }, and are told when this page is ready, and the answer.

addEventListener("message", ({ data, source }) => {
  const reply = told => source?.postMessage({ from: "foldpath", ...told }, "*");
  const bytes = text => new TextEncoder().encode(text);
  if (data?.op === "importFold" && data.fold) openPattern(`${data.fold.file_title || "message"}.fold`, bytes(JSON.stringify(data.fold)), reply);
  else if (data?.op === "importSVG" && data.svg) openPattern(data.filename || "message.svg", bytes(data.svg), reply);
});

begin();
const other = window.parent !== window ? window.parent : window.opener;
other?.postMessage({ from: "foldpath", status: "ready" }, "*");
