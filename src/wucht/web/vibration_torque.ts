/**
 * The torque with which the vibration of a linear carrier brakes the bodies that excite it, as `wucht.analysis.vibration`.
 *
 * (K - w^2 M + i w C) z = w^2 F; the torque on all bodies is w z^H C z / 2, on some of them -w^2/2 Im[conj(F_of these) z].
 */

/** Share of the bodies' unbalances that remains where they cancel. */
const CANCELLATION = 1e-12;
/** Of the stiffness: damping that keeps the matrix regular at the natural frequency of an undamped direction. */
const REGULARISATION = 1e-14;

export class VibrationTorque {
  private readonly size: number;
  private readonly count: number;
  /** M, C, K by rows. */
  private readonly mass: Float64Array;
  private readonly damping: Float64Array;
  private readonly stiffness: Float64Array;
  private readonly real: Float64Array;
  private readonly imaginary: Float64Array;
  /** Force of all bodies, force of those that are braked, and the solution: real and imaginary parts in turn. */
  private readonly force: Float64Array;
  private readonly memberForce: Float64Array;
  private readonly solution: Float64Array;
  /** Whether no other body excites than those that are braked. */
  private isAlone = true;
  private regularisation = 0;

  constructor(size: number, count: number) {
    this.size = size;
    this.count = count;
    this.mass = new Float64Array(size * size);
    this.damping = new Float64Array(size * size);
    this.stiffness = new Float64Array(size * size);
    this.real = new Float64Array(size * size);
    this.imaginary = new Float64Array(size * size);
    this.force = new Float64Array(2 * size);
    this.memberForce = new Float64Array(2 * size);
    this.solution = new Float64Array(2 * size);
  }

  /**
   * Take the matrices, and the phases of the bodies.
   *
   * matrices: M, C, K by rows, then the real and the imaginary parts of the forces of the bodies. angles: absolute. senses: in
   * which they turn. counts, members: flags of the bodies that excite, and of those that are braked.
   */
  set(matrices: Float64Array, angles: Float64Array, senses: Float64Array, counts: Uint8Array, members: Uint8Array): void {
    const square = this.size * this.size;
    let largest = 0;
    for (let i = 0; i < square; i++) {
      this.mass[i] = matrices[i]!;
      this.damping[i] = matrices[square + i]!;
      this.stiffness[i] = matrices[2 * square + i]!;
      largest = Math.max(largest, Math.abs(this.stiffness[i]!));
    }
    this.regularisation = REGULARISATION * (largest || 1);
    this.isAlone = true;
    for (let d = 0; d < this.size; d++) this.sum(d, matrices, angles, senses, counts, members);
  }

  /** The torque on the members while all bodies turn with a speed, each in its sense; positive where it brakes. */
  torque(speed: number): number {
    const { size, force, solution, memberForce, damping } = this;
    const square = speed * speed;
    for (let i = 0; i < size * size; i++) {
      this.real[i] = this.stiffness[i]! - square * this.mass[i]!;
      this.imaginary[i] = speed * damping[i]!;
    }
    for (let i = 0; i < size; i++) this.imaginary[i * (size + 1)]! += this.regularisation;
    for (let i = 0; i < 2 * size; i++) solution[i] = square * force[i]!;
    solve(this.real, this.imaginary, solution, size);
    let total = 0;
    if (this.isAlone) {
      for (let i = 0; i < size; i++) {
        for (let j = 0; j < size; j++) {
          const product = solution[2 * i]! * solution[2 * j]! + solution[2 * i + 1]! * solution[2 * j + 1]!;
          total += damping[i * size + j]! * product;
        }
      }
      return (speed * total) / 2;
    }
    for (let i = 0; i < size; i++) {
      total += memberForce[2 * i]! * solution[2 * i + 1]! - memberForce[2 * i + 1]! * solution[2 * i]!;
    }
    return (-square / 2) * total;
  }

  /**
   * Add the forces in one direction, which are zero where they cancel.
   *
   * U e exp(i alpha) of a body of sense s is conjugate where s < 0, and alpha = s angle.
   */
  private sum(
    d: number, matrices: Float64Array, angles: Float64Array, senses: Float64Array, counts: Uint8Array, members: Uint8Array,
  ): void {
    const { size, count, force, memberForce } = this;
    const start = 3 * size * size;
    let [re, im, scale, memberRe, memberIm, memberScale] = [0, 0, 0, 0, 0, 0];
    for (let k = 0; k < count; k++) {
      if (counts[k] === 0) continue;
      const sense = senses[k]!;
      const a = matrices[start + k * size + d]!;
      const b = sense * matrices[start + (count + k) * size + d]!;
      const alpha = sense * angles[k]!;
      const [x, y] = [a * Math.cos(alpha) - b * Math.sin(alpha), a * Math.sin(alpha) + b * Math.cos(alpha)];
      const magnitude = Math.hypot(a, b);
      re += x;
      im += y;
      scale += magnitude;
      if (members[k] === 1) {
        memberRe += x;
        memberIm += y;
        memberScale += magnitude;
      } else if (magnitude > 0) this.isAlone = false;
    }
    const cancels = Math.hypot(re, im) <= CANCELLATION * scale;
    const memberCancels = Math.hypot(memberRe, memberIm) <= CANCELLATION * memberScale;
    force[2 * d] = cancels ? 0 : re;
    force[2 * d + 1] = cancels ? 0 : im;
    memberForce[2 * d] = memberCancels ? 0 : memberRe;
    memberForce[2 * d + 1] = memberCancels ? 0 : memberIm;
  }
}

/** Solve (A + i B) x = x in place, by Gauss' elimination with pivots. x: real and imaginary parts in turn. */
function solve(a: Float64Array, b: Float64Array, x: Float64Array, size: number): void {
  for (let k = 0; k < size; k++) {
    let pivot = k;
    for (let i = k + 1; i < size; i++) {
      if (squareOf(a, b, i * size + k) > squareOf(a, b, pivot * size + k)) pivot = i;
    }
    if (pivot !== k) {
      for (let j = 0; j < size; j++) {
        swap(a, k * size + j, pivot * size + j);
        swap(b, k * size + j, pivot * size + j);
      }
      swap(x, 2 * k, 2 * pivot);
      swap(x, 2 * k + 1, 2 * pivot + 1);
    }
    const [re, im] = [a[k * size + k]!, b[k * size + k]!];
    const norm = re * re + im * im;
    for (let i = k + 1; i < size; i++) {
      const [c, d] = [a[i * size + k]!, b[i * size + k]!];
      const fr = (c * re + d * im) / norm;
      const fi = (d * re - c * im) / norm;
      for (let j = k; j < size; j++) {
        const [p, q] = [a[k * size + j]!, b[k * size + j]!];
        a[i * size + j]! -= fr * p - fi * q;
        b[i * size + j]! -= fr * q + fi * p;
      }
      const [p, q] = [x[2 * k]!, x[2 * k + 1]!];
      x[2 * i]! -= fr * p - fi * q;
      x[2 * i + 1]! -= fr * q + fi * p;
    }
  }
  for (let k = size - 1; k >= 0; k--) {
    let [re, im] = [x[2 * k]!, x[2 * k + 1]!];
    for (let j = k + 1; j < size; j++) {
      const [p, q] = [a[k * size + j]!, b[k * size + j]!];
      re -= p * x[2 * j]! - q * x[2 * j + 1]!;
      im -= p * x[2 * j + 1]! + q * x[2 * j]!;
    }
    const [c, d] = [a[k * size + k]!, b[k * size + k]!];
    const norm = c * c + d * d;
    x[2 * k] = (re * c + im * d) / norm;
    x[2 * k + 1] = (im * c - re * d) / norm;
  }
}

function squareOf(a: Float64Array, b: Float64Array, i: number): number {
  return a[i]! * a[i]! + b[i]! * b[i]!;
}

function swap(values: Float64Array, i: number, j: number): void {
  const value = values[i]!;
  values[i] = values[j]!;
  values[j] = value;
}
