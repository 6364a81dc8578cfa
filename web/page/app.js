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
  : fetch("foldpath_bg.wasm").then(response => response.arrayBuffer()).then(bytes => WebAssembly.compile(bytes));
const noModule = error => say(`The module does not load (${error.message}). From a disk, open foldpath.html.`, true);
compiled.catch(noModule);

const source = inlined.worker
  ? URL.createObjectURL(new Blob([inlined.worker.textContent], { type: "text/javascript" }))
  : "worker.js";

function begin() {
  worker = new Worker(source);
  let answers = false;
  const begun = worker;
  compiled.then(module => begun.postMessage({ module }), () => {});
  worker.onmessage = ({ data: { id, told, result, error } }) => {
    answers = true;
    const call = waiting.get(id);
    if (!call) return;
    if (told) return call.told?.(told);
    waiting.delete(id);
    if (error === undefined) call.resolve(result); else call.reject(new Error(error));
  };
  // The module stops for good where it ends by itself.
  worker.onerror = event => end(`The module has stopped: ${event.message ?? "it does not load"}`, answers);
}

/** Why a call has no answer: it was ended by the user, or by another call. */
class Ended extends Error {}

/** Ends the worker, and every call that waits for it, and begins another unless this one never answered. */
function end(why, again = true) {
  worker.terminate();
  const ended = [...waiting.values()];
  waiting.clear();
  if (again) begin(); else say(why, true);
  ended.forEach(call => call.reject(new Ended(why)));
}

async function ask(call, more = {}, told) {
  await compiled;
  return new Promise((resolve, reject) => {
    waiting.set(++calls, { resolve, reject, told });
    worker.postMessage({ id: calls, call, ...more });
  });
}

// ---- The pattern and its plan.

/** The file that is open: { name, bytes, call, reply }, what is done with it, and a way to answer who sent it. */
let opened = null;
/** Number of the plan that is asked for last: answers to others are late. */
let latest = 0;

/** Options of judging a path. */
const CHECKED = ["bound", "bend"];

/** The options of the form by their names on the command line, without those that are left as they are. */
function chosen(call) {
  const all = [...new FormData(options)].filter(([name, value]) => value.trim() !== "" && (call === "plan" || CHECKED.includes(name)));
  return Object.fromEntries(all.map(([name, value]) => [name, name === "crease" ? value.trim().split(/[\s,]+/) : value.trim()]));
}

function say(text, isNo = false) {
  status.textContent = text;
  status.classList.toggle("no", isNo);
}

/** Returns `true` if a file is a FOLD file with a path. */
function isPath(name, bytes) {
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
  const number = ++latest, file = opened, call = file.call;
  say(`${file.name}: working`);
  element("answer").hidden = true;
  cancel.hidden = progress.hidden = false;
  progress.removeAttribute("value");
  const told = ({ stage, part }) => {
    say(`${file.name}: ${stage}`);
    if (part === undefined) progress.removeAttribute("value"); else progress.value = part;
  };
  try {
    const { json, page, hasPath } = await ask(call, { name: file.name, bytes: file.bytes, options: chosen(call) }, told);
    if (number !== latest) return;
    const answer = JSON.parse(json);
    show(file, answer, page, call === "plan" && hasPath);
    file.reply?.({ outcome: answer.outcome, answer });
  } catch (error) {
    if (number !== latest && file !== opened) file.reply?.({ outcome: null, error: error.message });
    if (number !== latest) return;
    say(error.message, true);
    file.reply?.({ outcome: null, error: error.message });
  } finally {
    if (number === latest) cancel.hidden = progress.hidden = true;
  }
}

const short = x => typeof x === "number" ? +x.toPrecision(4) : x;

function show(file, json, page, hasPath) {
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
  element("files").hidden = !hasPath;
  element("answer").hidden = false;
  element("view").srcdoc = page;
}

function openPattern(name, bytes, reply) {
  opened = { name, bytes, call: isPath(name, bytes) ? "check" : "plan", reply };
  return answer();
}

async function openFile(file) {
  if (!file) return;
  try {
    await openPattern(file.name, new Uint8Array(await file.arrayBuffer()));
  } catch (error) {
    say(`${file.name}: ${error.message}`, true); // a folder, for example
  }
}

// ---- Files, buttons and the form.

const ENDINGS = { fold: ".path.fold", glb: ".glb", csv: ".csv", traj: ".traj", pattern: ".svg" };

async function download(format) {
  try {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([await ask("file", { format })]));
    link.download = opened.name.replace(/\.[^.]*$/, "") + ENDINGS[format];
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  } catch (error) {
    if (!(error instanceof Ended)) say(error.message, true);
  }
}

addEventListener("dragover", event => { event.preventDefault(); document.body.classList.add("over"); });
addEventListener("dragleave", () => document.body.classList.remove("over"));
addEventListener("drop", event => {
  event.preventDefault();
  document.body.classList.remove("over");
  openFile(event.dataTransfer.files[0]);
});
element("file").addEventListener("change", event => {
  openFile(event.target.files[0]);
  event.target.value = ""; // so that the same file can be chosen again
});
element("example").addEventListener("click", async () => {
  try {
    const text = await ask("generate", { family: { family: "miura", rows: 11, cols: 11 } });
    await openPattern("miura-11x11.fold", new TextEncoder().encode(text));
  } catch (error) {
    if (!(error instanceof Ended)) noModule(error);
  }
});
element("files").addEventListener("click", event => { if (event.target.value) download(event.target.value); });
options.addEventListener("change", answer);
options.addEventListener("submit", event => event.preventDefault());
cancel.addEventListener("click", () => end("cancelled"));

// ---- Other windows. They send a pattern as to Origami Simulator, { op: "importFold", fold } or { op: "importSVG", svg,
// filename }, and are told when this page is ready, and the answer with the `id` of the message, if it has one.

addEventListener("message", ({ data, source }) => {
  const reply = told => source?.postMessage({ from: "foldpath", id: data.id, ...told }, "*");
  const bytes = text => new TextEncoder().encode(text);
  if (data?.op === "importFold" && data.fold) openPattern(`${data.fold.file_title || "message"}.fold`, bytes(JSON.stringify(data.fold)), reply);
  else if (data?.op === "importSVG" && data.svg) openPattern(`${data.filename || "message"}`.replace(/(\.svg)?$/i, ".svg"), bytes(`${data.svg}`), reply);
});

begin();
const other = window.parent !== window ? window.parent : window.opener;
other?.postMessage({ from: "foldpath", status: "ready" }, "*");
