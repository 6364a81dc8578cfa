// foldpath for programs in JavaScript. See index.d.ts.
import initialise, { check as checkFile, draw as drawFile, families as listed, generate as generateFile, info as describe, plan as planFile, unfold, version, view } from "./foldpath.js";

const bytesOf = file => typeof file === "string" ? new TextEncoder().encode(file) : file;

/** Prepares the module; has to end before any other call. */
export async function load(module) {
  await initialise({ module_or_path: module ?? await ownModule() });
}

/** Returns the address of the module beside this file, or its bytes where addresses of files cannot be fetched. */
async function ownModule() {
  const address = new URL("foldpath_bg.wasm", import.meta.url);
  if (address.protocol !== "file:" || typeof process === "undefined") return address;
  const { readFile } = await import("node:fs/promises");
  return readFile(address);
}

export const generate = family => generateFile(JSON.stringify(family));
export const families = () => JSON.parse(listed());
export const draw = (name, file, options = {}) => drawFile(String(name), bytesOf(file), JSON.stringify(options));
export const info = (name, file, options = {}) => JSON.parse(describe(String(name), bytesOf(file), JSON.stringify(options)));
export const check = (name, file, options = {}, told) => JSON.parse(checkFile(String(name), bytesOf(file), JSON.stringify(options), told));
export { unfold, version, view };

export function plan(name, file, options = {}, told) {
  const planned = planFile(String(name), bytesOf(file), JSON.stringify(options), told);
  return { answer: JSON.parse(planned.json), suggestions: JSON.parse(planned.suggestions), hasPath: planned.has_path, page: () => planned.page(), file: format => planned.file(format), free: () => planned.free() };
}
