// Run jobs of test_live_drawing.py and test_torque_hills.py: node live_drawing_jobs.mjs ENGINE JOBS.json RESULTS.json
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [engine, jobs, results] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${engine}/${name}.ts`).href);
const { MachineDrawing } = await load("drawing");
const { Pose } = await load("pose");
const { TorqueCurves } = await load("torque_curves");
const { TorqueHill } = await load("torque_hill");

/** A context of a canvas that records circles and words, counts what is not finite, and does nothing else. */
function recorder() {
  const calls = { arcs: [], words: [], infinite: 0 };
  const context = new Proxy({ measureText: (words) => ({ width: 6 * words.length }) }, {
    get(target, name) {
      if (name in target) return target[name];
      return (...values) => {
        if (values.some((value) => typeof value === "number" && !Number.isFinite(value))) calls.infinite += 1;
        if (name === "arc") calls.arcs.push(values.slice(0, 3));
        if (name === "fillText") calls.words.push(values[0]);
      };
    },
    set: () => true,
  });
  return { calls, context };
}

/** A canvas of 640 x 480 CSS pixels. */
function canvasOf({ context }) {
  return { clientWidth: 640, clientHeight: 480, width: 0, height: 0, style: {}, getContext: () => context, setAttribute() {} };
}

const values = (machine, changes = {}) => Float64Array.from(machine.parameters, ({ path, value }) => changes[path] ?? value);
const startOf = (machine) => Float64Array.from(machine.states, ({ start }) => start);

/** Circles drawn in a view, the part at each point, and the states that it has there and elsewhere. */
function draw(machine, { view, state = startOf(machine), parameters, grabs = [], amplitude = 0, outputs = [], trace = null, held = false }) {
  const recording = recorder();
  const drawing = new MachineDrawing(canvasOf(recording), machine);
  const suggested = drawing.suggestedMagnification(amplitude);
  drawing.draw(0, state, outputs, values(machine, parameters), view, trace === null ? null : { axis: Float64Array.from(trace), deck: [] });
  if (held) drawing.draw(0, state, [], values(machine, parameters), view, null);
  const parts = grabs.map(({ from, to }) => {
    const part = drawing.partAt(...from);
    return { part, same: part && [...drawing.stateWithPartAt(part, ...from, state)], moved: part && [...drawing.stateWithPartAt(part, ...to, state)] };
  });
  return { ...recording.calls, parts, suggested, description: drawing.description };
}

/** Lengths at values of the parameters. */
function lengths(machine, { parameters }) {
  const pose = new Pose(machine);
  pose.update(startOf(machine), [], values(machine, parameters), 1);
  return [...pose.lengths];
}

/** Torques over speeds, and the steady speeds between them. */
function torques(machine, { rotor, speeds, time, state = startOf(machine), parameters }) {
  const curves = new TorqueCurves(machine, machine.hills);
  curves.set(values(machine, parameters), time, state, rotor);
  const table = new Float64Array(3 * speeds.length);
  speeds.forEach((speed, i) => curves.torques(speed, table.subarray(3 * i, 3 * i + 3)));
  return { torques: [...table], range: curves.range(), points: curves.workingPoints(speeds.length, speeds, table) };
}

/** The hill as it is drawn. */
function hill(machine, { time, state = startOf(machine), speedTrace = null, torqueTrace = null, parameters }) {
  const recording = recorder();
  const host = { ownerDocument: { createElement: () => canvasOf(recording) }, append() {} };
  const panel = new TorqueHill(host, machine);
  const trace = (numbers) => (numbers === null ? null : Float64Array.from(numbers));
  panel.draw(values(machine, parameters), trace(speedTrace), trace(torqueTrace), time, state);
  const { available, reason, rotors, workingPoints } = panel;
  return { ...recording.calls, available, reason, rotors, points: workingPoints };
}

const answers = [];
for (const { script, kind, ...job } of JSON.parse(readFileSync(jobs, "utf8"))) {
  const { machine } = await import(pathToFileURL(script).href);
  answers.push({ draw, lengths, torques, hill }[kind](machine, job));
}
writeFileSync(results, JSON.stringify(answers));
