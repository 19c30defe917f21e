// Run jobs of test_live_machine.py: node live_machine_jobs.mjs ENGINE JOBS.json RESULTS.json
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [engine, jobs, results] = process.argv.slice(2);
const { Equations } = await import(pathToFileURL(`${engine}/equations.ts`).href);
const { Integrator } = await import(pathToFileURL(`${engine}/integrator.ts`).href);

/** Rates and outputs at times, in states, with values of the parameters. */
function evaluate(machine, { points }) {
  const equations = new Equations(machine);
  return points.map(({ time, state, parameters }) => {
    const x = Float64Array.from(state);
    const rates = new Float64Array(machine.states.length);
    const outputs = new Float64Array(machine.outputs.length);
    equations.setParameters(parameters);
    equations.locate(time, x);
    equations.rates(time, x, rates);
    equations.shown(time, x, outputs);
    return { rates: [...rates], outputs: [...outputs] };
  });
}

/** A run from the start, sampled evenly; its duration is that of the last repetition. */
function run(machine, { tolerance, end, count, repetitions }) {
  const integrator = new Integrator(machine, tolerance);
  const [n, m] = [machine.states.length, machine.outputs.length];
  const grid = Float64Array.from({ length: count }, (_, i) => (end * i) / (count - 1));
  const [states, outputs] = [new Float64Array(count * n), new Float64Array(count * m)];
  let result = {};
  for (let i = 0; i < (repetitions ?? 1); i++) {
    const begin = performance.now();
    integrator.start(0, machine.states.map((state) => state.start));
    const { ending, count: samples } = integrator.advance(grid, states, outputs);
    result = { ending, samples, milliseconds: performance.now() - begin };
  }
  return { ...result, steps: integrator.stepCount, switches: integrator.switchCount, states: [...states], outputs: [...outputs] };
}

const answers = [];
for (const job of JSON.parse(readFileSync(jobs, "utf8"))) {
  const { machine } = await import(pathToFileURL(job.script).href);
  answers.push(job.points ? evaluate(machine, job) : run(machine, job));
}
writeFileSync(results, JSON.stringify(answers));
