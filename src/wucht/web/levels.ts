/** Speeds that are marked: natural frequencies, and what the motors reach without vibration. They move with the parameters. */

import type { Contents } from "./page_data.ts";
import { TorqueCurves } from "./torque_curves.ts";

export interface Level {
  readonly name: string;
  /** In rad per unit of time. */
  readonly speed: number;
  readonly isNatural: boolean;
}

const SWEEPS = 30;

export class Levels {
  private readonly _contents: Contents;
  private readonly _original: readonly number[];
  private readonly _start: Float64Array;
  private readonly _torques: TorqueCurves | null;

  constructor(contents: Contents) {
    const { hills, parameters, states } = contents.machine;
    this._contents = contents;
    this._original = parameters.map(({ value }) => value);
    this._start = Float64Array.from(states, ({ start }) => start);
    this._torques = hills.available ? new TorqueCurves(contents.machine, hills) : null;
  }

  /** The speeds at values of the parameters, at the end of schedules; at those of the file, as Python has them. */
  at(parameters: readonly number[], end: number): Level[] {
    const { rotors } = this._contents.page.levels;
    const natural = distinct(this._naturalFrequencies(parameters));
    const levels = natural.map((speed) => {
      return { name: "natural frequency", speed, isNatural: true };
    });
    for (const rotor of rotors) {
      const isOriginal = rotor.depends.every((index) => parameters[index] === this._original[index]);
      const speed = isOriginal ? rotor.speed : this._freeSpeed(rotor.name, parameters, end);
      const name = rotors.length > 1 ? `${rotor.name} without vibration` : "speed without vibration";
      if (speed !== null && speed !== 0) levels.push({ name, speed, isNatural: false });
    }
    return levels;
  }

  private _naturalFrequencies(parameters: readonly number[]): number[] {
    const { page, levelCode } = this._contents;
    const constants = new Float64Array(levelCode.matrices.constantCount);
    const entries = new Float64Array(2 * page.levels.size ** 2);
    levelCode.matrices.constants(Float64Array.from(parameters), constants);
    levelCode.matrices.values(0, new Float64Array(0), constants, entries);
    return naturalFrequencies(entries, page.levels.size);
  }

  /** The speed that a motor reaches without vibration; null where it is not known here. */
  private _freeSpeed(name: string, parameters: readonly number[], end: number): number | null {
    const row = this._torques?.hills.rotors.findIndex((rotor) => rotor.name === name) ?? -1;
    if (this._torques === null || row < 0) return null;
    this._torques.set(parameters, end, this._start, row);
    return this._torques.freeSpeed();
  }
}

/** Each frequency once: those of equal directions are one line. */
function distinct(frequencies: readonly number[]): number[] {
  return frequencies.filter((f, i) => f > 0 && !frequencies.slice(0, i).some((other) => Math.abs(f - other) < 1e-9 * f));
}

/**
 * Frequencies from a mass and a stiffness matrix, both symmetric, the lowest first: the eigenvalues of L^-1 K L^-T with
 * M = L L^T, by Jacobi's rotations. None where the mass matrix is not positive.
 *
 * @param entries of both matrices, row by row (2 size^2)
 */
export function naturalFrequencies(entries: ArrayLike<number>, size: number): number[] {
  const lower = cholesky(entries, size);
  if (lower === null) return [];
  const matrix = Array.from({ length: size }, (_row, i) =>
    Array.from({ length: size }, (_entry, j) => entries[size * (size + i) + j]!),
  );
  for (const transposed of [false, true]) {
    for (let column = 0; column < size; column++) {
      for (let i = 0; i < size; i++) {
        let sum = transposed ? matrix[column]![i]! : matrix[i]![column]!;
        for (let k = 0; k < i; k++) sum -= lower[i]![k]! * (transposed ? matrix[column]![k]! : matrix[k]![column]!);
        if (transposed) matrix[column]![i] = sum / lower[i]![i]!;
        else matrix[i]![column] = sum / lower[i]![i]!;
      }
    }
  }
  return eigenvalues(matrix)
    .map((square) => Math.sqrt(Math.max(square, 0)))
    .sort((a, b) => a - b);
}

function cholesky(entries: ArrayLike<number>, size: number): number[][] | null {
  const lower = Array.from({ length: size }, () => Array.from({ length: size }, () => 0));
  for (let i = 0; i < size; i++) {
    for (let j = 0; j <= i; j++) {
      let sum = entries[size * i + j]!;
      for (let k = 0; k < j; k++) sum -= lower[i]![k]! * lower[j]![k]!;
      if (i === j && !(sum > 0)) return null;
      lower[i]![j] = i === j ? Math.sqrt(sum) : sum / lower[j]![j]!;
    }
  }
  return lower;
}

/** Eigenvalues of a symmetric matrix, which is overwritten: by Jacobi's rotations, each of which makes two entries zero. */
function eigenvalues(a: number[][]): number[] {
  const n = a.length;
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    for (let p = 0; p < n; p++) {
      for (let q = p + 1; q < n; q++) {
        if (a[p]![q] === 0) continue;
        const theta = (a[q]![q]! - a[p]![p]!) / (2 * a[p]![q]!);
        const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
        const c = 1 / Math.sqrt(t * t + 1);
        const s = t * c;
        for (let k = 0; k < n; k++) {
          const [x, y] = [a[k]![p]!, a[k]![q]!];
          a[k]![p] = c * x - s * y;
          a[k]![q] = s * x + c * y;
        }
        for (let k = 0; k < n; k++) {
          const [x, y] = [a[p]![k]!, a[q]![k]!];
          a[p]![k] = c * x - s * y;
          a[q]![k] = s * x + c * y;
        }
      }
    }
  }
  return a.map((row, i) => row[i]!);
}
