"use strict";
// Calls the module, so that the page stays alive meanwhile. Messages to the worker: { module } once, the compiled
// WebAssembly module; { id, call, ... }. Messages from it: { id, told }, and in the end { id, result } or
// { id, error }.

let planned, begin;
const ready = new Promise(resolve => { begin = resolve; });

/** Formats of shapes in space, which are laid flat first. */
const SHAPES = /\.(obj|stl)$/i;
const laidFlat = ({ name, bytes }) => SHAPES.test(name)
  ? [name.replace(SHAPES, ".fold"), new TextEncoder().encode(wasm_bindgen.unfold(name, bytes))]
  : [name, bytes];

const CALLS = {
  families: () => wasm_bindgen.families(),
  generate: ({ family }) => wasm_bindgen.generate(JSON.stringify(family)),
  draw: ({ options, ...file }) => wasm_bindgen.draw(...laidFlat(file), JSON.stringify(options)),
  plan({ options, ...file }, told) {
    planned?.free();
    planned = undefined;
    planned = wasm_bindgen.plan(...laidFlat(file), JSON.stringify(options), told);
    const { json, suggestions, has_path: hasPath } = planned;
    return { json, suggestions, page: planned.page(), hasPath };
  },
  check: ({ name, bytes, options }, told) => ({ json: wasm_bindgen.check(name, bytes, JSON.stringify(options), told), page: wasm_bindgen.view(name, bytes) }),
  file: ({ format }) => planned.file(format),
};

onmessage = async ({ data }) => {
  if (data.module) {
    begin(wasm_bindgen({ module_or_path: data.module }));
    return;
  }
  const { id, call } = data;
  try {
    await ready;
    postMessage({ id, result: CALLS[call](data, (stage, part) => postMessage({ id, told: { stage, part } })) });
  } catch (error) {
    // A module that has panicked, or has no more memory or stack, is not called again: the page begins another worker.
    if (error instanceof WebAssembly.RuntimeError || error instanceof RangeError) return setTimeout(() => { throw error; });
    postMessage({ id, error: String(error.message ?? error), suggestions: error.suggestions });
  }
};
