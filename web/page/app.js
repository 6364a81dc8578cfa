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
  worker.onmessage = ({ data: { id, told, result, error, suggestions } }) => {
    answers = true;
    const call = waiting.get(id);
    if (!call) return;
    if (told) return call.told?.(told);
    waiting.delete(id);
    if (error === undefined) call.resolve(result); else call.reject(Object.assign(new Error(error), { suggestions }));
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

begin();

// ---- The pattern and its plan.

/** The file that is open: { name, bytes, call, reply, family }: what is done with it, a way to answer who sent it, and the family
 * with its parameters if it was made here. */
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

/** Takes the last answer and its picture away. */
function clear() {
  for (const part of ["answer", "next", "view", "pattern"]) element(part).hidden = true;
  element("view").srcdoc = "";
}

/** Options of reading a drawing. */
const READING = ["tolerance", "straighten", "colors"];
/** Size of a file, bytes, up to which its pattern is drawn before it is planned. */
const MOST_DRAWN = 2e6;

/** Shows the flat pattern of a file while nothing else is known of it. */
async function draw(file, number) {
  if (file.call !== "plan" || file.bytes.length > MOST_DRAWN) return;
  const reading = Object.entries(chosen("plan")).filter(([name]) => READING.includes(name));
  const svg = await ask("draw", { name: file.name, bytes: file.bytes, options: Object.fromEntries(reading) });
  if (number !== latest) return;
  const picture = element("pattern");
  URL.revokeObjectURL(picture.src);
  picture.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  picture.alt = `Crease pattern of ${file.name}`;
  picture.hidden = false;
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
  clear();
  cancel.hidden = progress.hidden = false;
  progress.removeAttribute("value");
  const told = ({ stage, part }) => {
    say(`${file.name}: ${stage}`);
    if (part === undefined) progress.removeAttribute("value"); else progress.value = part;
  };
  try {
    await draw(file, number);
    const { json, suggestions, page, hasPath } = await ask(call, { name: file.name, bytes: file.bytes, options: chosen(call) }, told);
    if (number !== latest) return;
    const answer = JSON.parse(json);
    show(file, answer, page, call === "plan" && hasPath);
    suggest(suggestions);
    file.reply?.({ outcome: answer.outcome, answer });
  } catch (error) {
    if (number !== latest && file !== opened) file.reply?.({ outcome: null, error: error.message });
    if (number !== latest) return;
    say(error.message, true);
    suggest(error.suggestions);
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
  element("view").hidden = false;
  element("pattern").hidden = true;
}

/** Offers each change of an option that may help, JSON, as a button. */
function suggest(suggestions) {
  const found = JSON.parse(suggestions ?? "[]").filter(({ option }) => options.elements[option]);
  element("next").querySelector("ul").replaceChildren(...found.map(({ option, value, sentence: [before, after] }) => {
    const field = options.elements[option], [item, button] = ["li", "button"].map(tag => document.createElement(tag));
    const label = field.closest("label").firstChild.textContent.trim();
    const shown = field.selectedOptions ? [...field.options].find(choice => choice.value === value).textContent : value;
    button.type = "button";
    button.textContent = `${before}“${label}”: ${shown}`;
    button.addEventListener("click", () => {
      field.value = value;
      status.tabIndex = -1; // the button is about to go, and with it the focus
      status.focus();
      answer();
    });
    item.append(button, after.trim());
    return item;
  }));
  element("next").hidden = !found.length;
}

function openPattern(name, bytes, reply, family) {
  opened = { name, bytes, call: isPath(name, bytes) ? "check" : "plan", reply, family };
  if (!family) showFamily();
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

// ---- The gallery of families.

/** Ranges of the sliders: least, most and step. */
const RANGES = { __proto__: null, rows: [1, 24, 1], cols: [1, 24, 1], angle: [1, 89, 1], fold: [0.01, 1, 0.01] };
const familyList = listFamilies();
async function listFamilies() {
  try {
    return JSON.parse(await ask("families"));
  } catch (error) {
    if (error instanceof Ended) return listFamilies(); // a file was opened meanwhile
    throw error;
  }
}
const family = element("family"), parameters = element("parameters");
element("numbers").open = innerWidth > 700; // on a phone the sheet is nearer
familyList.then(list => {
  family.append(...list.map(({ name, title }) => new Option(title, name)));
  if (opened?.family) showFamily(opened.family);
}, () => {});

/** Shows the sliders of a family at these values, or at its own; no family, no sliders. */
async function showFamily(given = {}) {
  const known = (await familyList).find(({ name }) => name === given.family);
  family.value = known?.name ?? "";
  element("about").textContent = known?.text ?? "";
  element("numbers").hidden = !known;
  parameters.replaceChildren(...(known?.parameters ?? []).map(({ name, text, names, default: own }) => {
    const label = document.createElement("label"), shown = document.createElement("output");
    const field = document.createElement(names ? "select" : "input"), value = given[name] ?? own;
    if (names) field.append(...names.map(choice => new Option(choice)));
    else [field.type, [field.min, field.max, field.step]] = ["range", RANGES[name]];
    // A value off the steps of its slider, as the goal of a quad.
    if (!names && Math.abs((value - field.min) / field.step % 1 - 0.5) < 0.499) field.step = "any";
    [field.name, field.value] = [name, value];
    field.addEventListener("input", () => { shown.textContent = short(+field.value); planFamily(); });
    shown.textContent = names ? "" : value;
    label.append(`${text} `, shown, field);
    return label;
  }));
}

/** Milliseconds without a change after which a pattern that is being changed is planned. */
const PAUSE = 300;
let pause = 0, making = false, changed = false;

/** Makes and draws the pattern of the sliders, as often as they have changed, and plans it once they are at rest. */
async function planFamily() {
  clearTimeout(pause);
  changed = true;
  if (making) return;
  making = true;
  try {
    while (changed) {
      changed = false;
      if (waiting.size) end("superseded");
      cancel.hidden = progress.hidden = true;
      opened = null;
      const number = ++latest, chosen = { family: family.value };
      parameters.querySelectorAll("input, select").forEach(({ name, value }) => { chosen[name] = value; });
      clear();
      const text = await ask("generate", { family: chosen });
      const name = `${[chosen.family, chosen.rows].join("-")}x${chosen.cols}.fold`;
      say(name);
      opened = { name, bytes: new TextEncoder().encode(text), call: "plan", family: chosen };
      await draw(opened, number);
    }
    pause = setTimeout(answer, PAUSE);
  } catch (error) {
    if (!(error instanceof Ended)) say(error.message, true);
  } finally {
    making = false;
  }
}

async function openFamily(chosen) {
  await showFamily(chosen);
  await planFamily();
}
family.addEventListener("change", () => { if (family.value) openFamily({ family: family.value }); });

// ---- Links. Behind the # they carry either a family with its parameters, or a file with its name, and options. Anybody may
// write a link: only what the page itself can set is taken.

/** Most characters of a link behind the #, and bytes of the file in it. */
const MOST_LINK = 32_000, MOST_BYTES = 1_000_000;
/** Names of files that links may carry: no folders, no control characters. */
const SAFE_NAME = /^[^\/\\\p{C}]{1,100}\.(fold|svg|cp|opx|obj|stl)$/iu;

const piped = (bytes, through) => new Blob([bytes]).stream().pipeThrough(through);

/** Packs bytes into the letters that an address may have (RFC 1951, RFC 4648). */
async function packed(bytes) {
  const small = new Uint8Array(await new Response(piped(bytes, new CompressionStream("deflate-raw"))).arrayBuffer());
  return btoa(Array.from(small, byte => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** Unpacks what `packed` made, and no more than MOST_BYTES of it. */
async function unpacked(text) {
  if (!/^[\w-]+$/.test(text)) throw new Error("expected letters of an address");
  const bytes = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), letter => letter.charCodeAt(0));
  const parts = [], reader = piped(bytes, new DecompressionStream("deflate-raw")).getReader();
  let size = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    size += part.value.length;
    if (size > MOST_BYTES) { reader.cancel(); throw new Error(`expected at most ${MOST_BYTES} bytes`); }
    parts.push(part.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

async function copyLink() {
  if (!opened) return say("Open a pattern first.", true);
  const link = new URLSearchParams(opened.family ?? { name: opened.name, file: await packed(opened.bytes) });
  for (const [name, value] of new FormData(options)) {
    if (value.trim() !== "" && value !== options.elements[name].defaultValue) link.append(`plan.${name}`, value.trim());
  }
  if (`${link}`.length > MOST_LINK) return say(`${opened.name} is too large for a link: it takes ${`${link}`.length} characters of at most ${MOST_LINK}.`, true);
  try {
    history.replaceState(null, "", `#${link}`);
    await navigator.clipboard.writeText(location.href);
    say("The link is copied: it carries the pattern and its options.");
  } catch {
    say("The link is in the address of this page: it carries the pattern and its options.");
  }
}

/** Returns `true` if a field of the page can have this value. */
function canHave(field, value) {
  if (!field || value.length > 200) return false;
  if (field.options) return [...field.options].some(choice => choice.value === value);
  const number = Number(value), { min, max } = field;
  return field.type === "text" || Number.isFinite(number) && (min === "" || number >= min) && (max === "" || number <= max);
}

/** Opens what the address of the page carries; returns `false` if it carries nothing. */
async function openLink() {
  const text = location.hash.slice(1);
  if (!text) return false;
  try {
    if (text.length > MOST_LINK) throw new Error(`expected at most ${MOST_LINK} characters`);
    const all = [...new URLSearchParams(text)], given = Object.fromEntries(all);
    const plan = all.filter(([name]) => name.startsWith("plan.")).map(([name, value]) => [name.slice(5), value]);
    const wrong = plan.find(([name, value]) => !canHave(options.elements[name], value));
    if (wrong) throw new Error(`no field of this page is ${wrong[0]} and can have ${wrong[1].slice(0, 50)}`);
    const rest = all.filter(([name]) => !name.startsWith("plan."));
    let open;
    if (given.family !== undefined) {
      const known = (await familyList).find(({ name }) => name === given.family);
      if (!known) throw new Error(`there is no family ${given.family.slice(0, 50)}`);
      for (const [name, value] of rest) {
        const parameter = known.parameters.find(parameter => parameter.name === name), [least, most] = RANGES[name] ?? [];
        const isGood = name === "family" || parameter && (parameter.names?.includes(value) ?? (value !== "" && value >= least && value <= most));
        if (!isGood) throw new Error(`no ${known.title} has ${name.slice(0, 50)} ${value.slice(0, 50)}`);
      }
      open = () => openFamily(Object.fromEntries(rest));
    } else {
      const other = rest.find(([name]) => !["name", "file"].includes(name));
      if (other) throw new Error(`${other[0].slice(0, 50)} is not known`);
      if (!SAFE_NAME.test(given.name ?? "")) throw new Error("expected the name of a pattern's file");
      const bytes = await unpacked(given.file ?? "").catch(error => { throw new Error(`the file is damaged: ${error.message}`); });
      open = () => openPattern(given.name, bytes);
    }
    options.reset();
    for (const [name, value] of plan) options.elements[name].value = value;
    await open();
  } catch (error) {
    if (!(error instanceof Ended)) { opened = null; clear(); say(`This link is not opened: ${error.message}`, true); }
  }
  return true;
}
addEventListener("hashchange", openLink);

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
element("files").addEventListener("click", event => { if (event.target.value) download(event.target.value); });
options.addEventListener("change", answer);
element("link").addEventListener("click", copyLink);
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

const other = window.parent !== window ? window.parent : window.opener;
other?.postMessage({ from: "foldpath", status: "ready" }, "*");
// A page that nobody sends anything begins with a pattern of the gallery.
openLink().then(isOpen => { if (!isOpen && !other) openFamily({ family: "miura" }).catch(noModule); });
