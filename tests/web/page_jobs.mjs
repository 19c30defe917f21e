// What the page's modules answer: node page_jobs.mjs WEB PAGE.html JOB.json, prints JSON.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [web, file, job] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${web}/${name}.ts`).href);
const [script] = /(?<=<script id="machine">)[\s\S]*?(?=<\/script>)/.exec(readFileSync(file, "utf8"));
const { machine, page, levelCode } = new Function(`${script}; return { machine, page, levelCode };`)();
const { originalScenario } = await load("scenario");
const original = originalScenario(machine, page.until);

/** A scenario with parameters by path and start states by name. */
function changed({ parameters = {}, start = {}, changes = [], until = page.until }) {
  const pick = (values, entries, names) => values.map((value, i) => entries[names[i]] ?? value);
  const paths = machine.parameters.map((parameter) => parameter.path);
  return {
    parameters: pick(original.parameters, parameters, paths),
    start: pick(
      original.start,
      start,
      machine.states.map((state) => state.name),
    ),
    until,
    changes: changes.map((change) => ({
      time: change.time,
      parameters: Object.entries(change.parameters ?? {}).map(([path, value]) => [paths.indexOf(path), value]),
      state: change.state ?? null,
    })),
  };
}

/** A canvas that keeps what is stroked on it, with its colour and dashes, and where words are written. */
function recordingCanvas(drawn, [clientWidth, clientHeight] = [640, 480]) {
  let [points, dashes] = [[], []];
  const calls = {
    measureText: () => ({ width: 0 }),
    beginPath: () => (points = []),
    moveTo: (...point) => points.push(point),
    lineTo: (...point) => points.push(point),
    setLineDash: (lengths) => (dashes = lengths),
    stroke: () => drawn.strokes.push({ points, dashes, colour: calls.strokeStyle }),
    fillText: (words, ...point) => drawn.words.push({ words, point }),
  };
  const context = new Proxy(calls, { get: (target, name) => target[name] ?? (() => {}) });
  return { clientWidth, clientHeight, style: {}, getContext: () => context, setAttribute() {} };
}

const jobs = {
  async levels({ values }) {
    const { Levels } = await load("levels");
    const levels = new Levels({ machine, page, levelCode });
    return values.map((parameters) => levels.at(changed({ parameters }).parameters, 1e6));
  },
  async study({ scenario }) {
    const { studyText } = await load("study_text");
    return studyText(changed(scenario), original, machine, page);
  },
  async link({ scenario, time }) {
    const { linkText, readLink } = await load("link");
    const shown = { scenario: changed(scenario), time, stroboscopic: true };
    const text = linkText(shown, original, machine);
    const again = readLink(text, original, machine);
    const bits = (numbers) => [...new BigUint64Array(Float64Array.from(numbers).buffer)].map(String);
    const every = ({ scenario: s, time: t }) =>
      bits([
        ...s.parameters,
        ...s.start,
        s.until,
        t,
        ...s.changes.flatMap((c) => [c.time, ...c.parameters.flat(), ...(c.state ?? [])]),
      ]);
    return { text, before: every(shown), after: every(again), strobe: again.stroboscopic };
  },
  /** What links show, or the sentence that refuses them. */
  async links({ texts }) {
    const { readLink, LinkError } = await load("link");
    return texts.map((text) => {
      try {
        return readLink(text, original, machine);
      } catch (error) {
        return error instanceof LinkError ? error.message : { error: `${error}` };
      }
    });
  },
  async course({ scenario }) {
    const { computeCourse } = await load("course");
    const course = computeCourse(machine, changed(scenario), page.turn);
    const n = machine.states.length;
    return { ending: course.ending, time: [...course.time], end: [...course.states.slice(-n)] };
  },
  /** The orbits as they are drawn, as displacements in m and in pixels, with their times, at times of a run. */
  async orbits({ scenario, times, tolerance }) {
    const { computeCourse, Instant } = await load("course");
    const { MachineDrawing } = await load("drawing");
    const { deckPlaces } = await load("deck");
    const { Integrator } = await load("integrator");
    const { Trails } = await load("trails");
    const course = computeCourse(machine, changed(scenario), page.turn, { tolerance, most: 12000 });
    const trails = new Trails({ machine, page, levelCode }, tolerance);
    const instant = new Instant(machine);
    const drawn = { strokes: [], words: [] };
    const drawing = new MachineDrawing(recordingCanvas(drawn), machine);
    const amplitude = machine.outputs.findIndex(({ name }) => name === "amplitude");
    const magnification = drawing.suggestedMagnification(trails.largest(course, amplitude));
    const view = { stroboscopic: false, magnification };
    const { advance } = Integrator.prototype;
    let grid = [];
    Integrator.prototype.advance = function (samples, ...rest) {
      grid = [...samples];
      return advance.call(this, samples, ...rest);
    };
    const orbits = times.map((time) => {
      instant.move(course, time);
      trails.move(course, time, instant);
      drawn.strokes.length = 0;
      drawing.draw(time, instant.state, instant.outputs, instant.parameters, view, trails.orbit);
      const { pen, pose } = drawing;
      const paths = drawn.strokes.map(({ points }) => points);
      const [, ...pixels] = paths.filter((path) => path.length > 1 && path.length === grid.length);
      const places = deckPlaces(pose);
      const moved = ([px, py], [a, b]) => [
        (pen.worldX(px, py) - a) / magnification,
        (pen.worldY(px, py) - b) / magnification,
      ];
      const displacements = pixels.map((path, i) => path.map((point) => moved(point, places[i])));
      return { time: grid, places, displacements, pixels };
    });
    return { magnification, description: drawing.description, orbits };
  },
  /** What is drawn of the machine at its start, on canvases of several sizes, with a motion of the main rotor's axis. */
  async drawings({ sizes, magnification, trace }) {
    const { MachineDrawing } = await load("drawing");
    const { start, parameters } = original;
    return sizes.map((size) => {
      const drawn = { strokes: [], words: [] };
      const orbits = { axis: Float64Array.from(trace), deck: [] };
      const view = { stroboscopic: false, magnification };
      new MachineDrawing(recordingCanvas(drawn, size), machine).draw(0, start, [], parameters, view, orbits);
      return drawn;
    });
  },
  /** Springs and dashpots from one point (m) to others, in a view. */
  async springs({ view, from, ends, width }) {
    const { Pen } = await load("shapes");
    return ends.map((end) => {
      const drawn = { strokes: [], words: [] };
      const pen = new Pen(recordingCanvas(drawn).getContext(), {});
      pen.setView(...view);
      pen.spring(...from, ...end, width, "");
      pen.dashpot(...from, ...end, width, 50, "");
      return drawn.strokes.map(({ points }) => points);
    });
  },
  /** The torque hill at the start. */
  async hill() {
    const { TorqueHill } = await load("torque_hill");
    const drawn = { strokes: [], words: [] };
    const hill = new TorqueHill({ ownerDocument: { createElement: () => recordingCanvas(drawn) }, append() {} }, machine);
    hill.draw(original.parameters, null, null, 0, original.start);
    return drawn;
  },
  async overlaps({ starts }) {
    const { overlapSentence } = await load("contacts");
    return starts.map((start) => overlapSentence(machine, original.parameters, Float64Array.from(changed({ start }).start)));
  },
  async measured({ texts }) {
    const { readMeasured, FileError } = await load("measured");
    return texts.map((text) => {
      try {
        return readMeasured(text, page.panels).map((c) => ({ ...c, time: [...c.time], values: [...c.values] }));
      } catch (error) {
        return error instanceof FileError ? error.message : `${error}`;
      }
    });
  },
  async sliders() {
    const { placeOf, refusal, valueAt } = await load("controls");
    return page.groups.flatMap((group) =>
      group.controls.map((control) => {
        const values = [0, 250, 500, 750, 1000].map((place) => valueAt(control, place));
        const value = original.parameters[control.indices[0]];
        return {
          name: control.name,
          values,
          refusals: values.map((v) => refusal(control, v)),
          value,
          place: placeOf(control, value),
        };
      }),
    );
  },
};
const { name, ...input } = JSON.parse(readFileSync(job, "utf8"));
console.log(JSON.stringify(await jobs[name](input)));
