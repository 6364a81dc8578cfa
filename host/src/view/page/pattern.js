'use strict';

// The page of a crease pattern: a click on a line describes its edge; a button lights the edges of a cause, a name or a
// crease group. The lines of the drawing are the edges of the pattern, in the order of their numbers.
(() => {
  const errors = [];
  window.addEventListener('error', (event) => errors.push(event.message));
  const scene = JSON.parse(document.getElementById('scene').textContent);
  const lines = [...document.querySelectorAll('main path')];
  const side = document.querySelector('aside');

  function add(kind, text) {
    const element = document.createElement(kind);
    element.textContent = text;
    side.append(element);
    return element;
  }

  add('h1', scene.title);
  const ask = add('label', 'Edge ').appendChild(document.createElement('input'));
  Object.assign(ask, { type: 'number', min: 0, max: scene.edges.length - 1 });
  ask.oninput = () => {
    if (scene.edges[ask.value]) light([Number(ask.value)], describe(Number(ask.value)));
  };
  const said = add('p', 'A click on a line, or its number above, describes its edge.');
  said.setAttribute('role', 'status');
  let lit = [];

  function light(edges, text) {
    for (const edge of lit) lines[edge].classList.remove('lit');
    for (const edge of edges) lines[edge].classList.add('lit');
    lit = edges;
    said.textContent = text;
  }

  function describe(number) {
    const { letter, goal, group, names } = scene.edges[number];
    const parts = [`edge ${number}: ${letter}`];
    if (goal !== null) parts.push(`goal ${Number(goal.toFixed(6))} degrees`);
    if (group !== 0) parts.push(`crease group ${Math.abs(group) - 1}${group < 0 ? ', turns against it' : ''}`);
    if (names.length > 0) parts.push(`names ${names.join(', ')}`);
    if (scene.locked.includes(number)) parts.push('cannot turn in a first step from flat');
    return parts.join('; ');
  }

  // Returns the edges that have each key.
  function edgesBy(keys) {
    const found = new Map();
    scene.edges.forEach((edge, number) => {
      for (const key of keys(edge)) found.set(key, [...(found.get(key) ?? []), number]);
    });
    return [...found];
  }

  function list(title, rows) {
    if (rows.length > 0) add('h2', title);
    for (const [text, edges] of rows) add('button', text).onclick = () => light(edges, text);
  }

  add('h2', `forecast: ${scene.verdict}`);
  list('In the way', scene.causes.map(({ message, edges }) => [message, edges]));
  list('Locked', scene.locked.length > 0 ? [['edges that cannot turn in a first step from flat', scene.locked]] : []);
  list('Names', edgesBy((edge) => edge.names));
  const groups = edgesBy((edge) => (edge.group === 0 ? [] : [Math.abs(edge.group) - 1]));
  const several = groups.filter(([, edges]) => edges.length > 1).sort(([a], [b]) => a - b);
  list('Crease groups', several.map(([group, edges]) => [`group ${group}: ${edges.length} edges`, edges]));

  lines.forEach((line, number) => {
    const hit = line.cloneNode();
    hit.setAttribute('class', 'hit');
    hit.dataset.edge = number;
    hit.onclick = () => light([number], describe(number));
    line.after(hit);
  });

  window.foldpath = { lit: () => lit, errors };
})();
