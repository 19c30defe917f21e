/** What lies behind the instant: the last turns of the axis and of the deck, and the rotor's speeds and torques up to now. */

import { FINE, sampleAt, type Course, type Instant } from "./course.ts";
import { deckOrbits, hasDeck, largestOfDeck, type Orbits } from "./deck.ts";
import { Integrator } from "./integrator.ts";
import type { Contents } from "./page_data.ts";
import { Pose } from "./pose.ts";

const TURN = 2 * Math.PI;
/** Turns of the orbit that are drawn, and points of each. */
const [TURNS, POINTS] = [2, 48];
/** Times the fastest turn: a slower one is not waited for. */
const SLOWEST = 20;
/** Samples of the way over the torque hill. */
const SAMPLES = 400;

export class Trails {
  orbit: Orbits | null = null;
  speeds: Float64Array | null = null;
  torques: Float64Array | null = null;
  private readonly _turn: number;
  private readonly _names: readonly string[];
  private readonly _places: { readonly x: number; readonly y: number; readonly speed: number };
  private _hill = { speed: -1, torque: -1 };
  private readonly _integrator: Integrator;
  /** Where the deck is; null without one. */
  private readonly _deck: Pose | null;
  private readonly _states: Float64Array;
  private readonly _outputs: Float64Array;
  private readonly _size: { readonly n: number; readonly m: number };

  /** tolerance: of a step. */
  constructor({ machine, page }: Contents, tolerance = FINE.tolerance) {
    this._names = machine.outputs.map((output) => output.name);
    const place = (name: string) => this._names.indexOf(name);
    this._turn = page.turn;
    this._places = { x: place("orbit.x"), y: place("orbit.y"), speed: page.panels[0]?.curves[0]?.output ?? 0 };
    this._integrator = new Integrator(machine, tolerance);
    this._deck = hasDeck(machine.drawing) ? new Pose(machine) : null;
    this._size = { n: machine.states.length, m: machine.outputs.length };
    this._states = new Float64Array((TURNS * POINTS + 1) * this._size.n);
    this._outputs = new Float64Array((TURNS * POINTS + 1) * this._size.m);
  }

  /** Follow another rotor over the torque hill. */
  select(rotor: string) {
    const alone = this._names.indexOf(`drive_torque[${rotor}]`);
    this._hill = {
      speed: this._names.indexOf(`speed[${rotor}]`),
      torque: alone < 0 ? this._names.indexOf("drive_torque") : alone,
    };
  }

  /** The largest displacement from rest in a course: of the axis, which is the output at this place, and of the deck. */
  largest(course: Course, place: number): number {
    let largest = this._deck === null ? 0 : largestOfDeck(this._deck, course, this._size.n);
    if (place < 0) return largest;
    for (let k = place; k < course.outputs.length; k += this._size.m)
      largest = Math.max(largest, Math.abs(course.outputs[k]!));
    return largest;
  }

  /** Go to a time of a course, with what is known of that instant. */
  move(course: Course, time: number, instant: Instant) {
    this._moveOrbit(course, time, instant);
    const { m } = this._size;
    const last = sampleAt(course, time);
    const first = Math.max(0, last - SAMPLES + 1);
    const column = (place: number) =>
      place < 0 ? null : Float64Array.from({ length: last - first + 1 }, (_, k) => course.outputs[(first + k) * m + place]!);
    this.speeds = column(this._hill.speed);
    this.torques = column(this._hill.torque);
  }

  private _moveOrbit(course: Course, time: number, instant: Instant) {
    const { x, y, speed } = this._places;
    if (x < 0 || y < 0) return;
    const turn = Math.min(SLOWEST * this._turn, TURN / Math.max(Math.abs(instant.outputs[speed]!), 1e-9));
    const change = course.scenario.changes.findLast((one) => one.time <= time);
    const sample = sampleAt(course, Math.max(time - TURNS * turn, change?.time ?? 0));
    const begin = course.time[sample]!;
    const { n, m } = this._size;
    const count = TURNS * POINTS + 1;
    const grid = Float64Array.from({ length: count }, (_, k) =>
      k === count - 1 ? time : begin + ((time - begin) * k) / (count - 1),
    );
    if (!(time > begin)) {
      this.orbit = null;
      return;
    }
    this._integrator.equations.setParameters(instant.parameters);
    this._integrator.start(begin, course.states.subarray(sample * n, (sample + 1) * n));
    const { count: reached } = this._integrator.advance(grid, this._states, this._outputs);
    const axis = Float64Array.from({ length: 2 * reached }, (_, k) => this._outputs[(k >> 1) * m + (k % 2 === 0 ? x : y)]!);
    this._deck?.update(instant.state, [], instant.parameters, 1);
    this.orbit = { axis, deck: this._deck === null ? [] : deckOrbits(this._deck, this._states, n, reached) };
  }
}
