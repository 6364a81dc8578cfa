// ---- Torques of the drivers, on a page that was made for a load: a panel of curves behind that of the angles.

const driverPeaks = scene.drivers.map((_, i) => most(shapes.map(shape => Math.abs(shape.torques?.[i] ?? 0))));
const strongest = scene.drivers.map((_, i) => i).sort((a, b) => driverPeaks[b] - driverPeaks[a]).slice(0, MOST_NAMED);
const torqueCurves = strongest.map((driver, i) => ({
  ...curve(`hinge ${scene.drivers[driver]}`, `hsl(${205 + 360 * i / strongest.length} 62% var(--curve-light))`, shape => shape.torques?.[driver]),
  text: value => Number.isFinite(value) ? `${short(value)} Nm` : "unknown",
}));
/** Steps of an axis of torques, which may be those of a sheet of some micrometres. */
const TORQUES = Array.from({ length: 90 }, (_, i) => [1, 2, 5][i % 3] * 10 ** (Math.floor(i / 3) - 18));
const torqueAxis = evenAxis(torqueCurves, TORQUES, 1e-18);
torqueAxis.label = x => (Math.abs(x) >= 1e-2 || x === 0 ? String(x) : x.toExponential()).replaceAll("-", "−");

const namedDrivers = strongest.length < scene.drivers.length ? `${strongest.length} of ${scene.drivers.length} drivers` : "the drivers";
element("angles").closest("figure").insertAdjacentHTML("afterend", `<figure>
  <figcaption><h2>Torques of ${namedDrivers} (Nm), ${short(driverPeaks[strongest[0]])} at most</h2> <ul id="torque-legend"></ul></figcaption>
  <div><svg id="torques" role="img" aria-label="Torques of the drivers against path time"></svg></div></figure>`);
plots.splice(1, 0, { svg: element("torques"), legend: element("torque-legend"), curves: torqueCurves, axis: torqueAxis });
