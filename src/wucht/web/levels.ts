/** Speeds that are marked: natural frequencies, and what the motors reach without vibration. They move with the parameters. */

import type { Code } from "./machine.ts";
import type { LevelCode, LevelData } from "./page_data.ts";

export interface Level {
  readonly name: string;
  /** In rad per unit of time. */
  readonly speed: number;
  readonly isNatural: boolean;
}

const SWEEPS = 30;
const NEARBY = 1e-3;
const GROWTH = 1.5;
const BISECTIONS = 200;

/** The speeds at values of the parameters; original: the values of the file, for which Python knows the speeds. */
export function levelsAt(
  data: LevelData,
  code: LevelCode,
  parameters: readonly number[],
  original: readonly number[],
): Level[] {
  const values = Float64Array.from(parameters);
  const natural = distinct(naturalFrequencies(evaluated(code.matrices, values, [], 2 * data.size ** 2), data.size));
  const levels = natural.map((speed, i) => {
    return { name: `natural frequency${natural.length > 1 ? ` ${i + 1}` : ""}`, speed, isNatural: true };
  });
  for (const [row, rotor] of data.rotors.entries()) {
    const isOriginal = rotor.depends.every((index) => parameters[index] === original[index]);
    let speed: number | null = isOriginal ? rotor.speed : null;
    if (!isOriginal && code.torques) speed = freeSpeed(code.torques, values, row, data.rotors.length);
    const name = data.rotors.length > 1 ? `${rotor.name} without vibration` : "without vibration";
    if (speed !== null && speed !== 0) levels.push({ name, speed, isNatural: false });
  }
  return levels;
}

/** Each frequency once: those of equal directions are one line. */
function distinct(frequencies: readonly number[]): number[] {
  return frequencies.filter((f, i) => f > 0 && !frequencies.slice(0, i).some((other) => Math.abs(f - other) < 1e-9 * f));
}

/** Results of code at parameters and states. */
function evaluated(code: Code, parameters: Float64Array, states: readonly number[], count: number): Float64Array {
  const constants = new Float64Array(code.constantCount);
  const results = new Float64Array(count);
  code.constants(parameters, constants);
  code.values(0, Float64Array.from(states), constants, results);
  return results;
}

/** The speed at which a rotor's net torque first vanishes, from standstill in its sense, as `free_speed` in Python; or null. */
function freeSpeed(code: Code, parameters: Float64Array, row: number, count: number): number | null {
  const torque = (speed: number) => evaluated(code, parameters, [speed], count)[row]!;
  const start = torque(0);
  if (!(start !== 0)) return null;
  let [low, high] = [0, Math.sign(start) * NEARBY];
  while (torque(high) * start > 0) {
    [low, high] = [high, GROWTH * high];
    if (!(Math.abs(high) < 1e9)) return null;
  }
  for (let i = 0; i < BISECTIONS && high !== low; i++) {
    const middle = 0.5 * (low + high);
    if (middle === low || middle === high) break;
    if (torque(middle) * start > 0) low = middle;
    else high = middle;
  }
  return high;
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
  const matrix = Array.from({ length: size }, (_, i) =>
    Array.from({ length: size }, (_, j) => entries[size * (size + i) + j]!),
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
  const lower = Array.from({ length: size }, () => new Array<number>(size).fill(0));
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
