"""Candidates of a design: their motion in averaged and full equations, and the distance of their spectra from a target."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wucht.dynamics.exciters.slow_beats import MOTIONS, Beat, beat_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import machine_signal
from wucht.dynamics.run_ups.observed_loads import load_histories
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.sampling.searches import Variable, values_at
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.fatigue.counted_cycles import LoadCycles, frequency_distance
from wucht.fatigue.counting import rainflow
from wucht.fatigue.cumulative_spectra import amplitude_distance
from wucht.fatigue.damage import WoehlerLine
from wucht.machines.machine import Machine

BEATING = (Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED)
METRICS = ("amplitude", "cumulative", "damage")
_NO_DISTANCE = (np.nan,) * len(METRICS)
_FAR = 1e3  # larger than any distance: of a candidate that does not beat
_SIMPLEX = 0.05  # of a range: the first step of a local search
_CLOSE = 1e-7  # of a range, and in the distance: tolerance of a local search


@dataclass(frozen=True)
class Candidates:
    """Evaluated candidates (P). numbers: values of the variables (P, k). distances: by each of ``METRICS`` (P, 3), nan where
    a candidate does not beat. motion (P,): indices into ``MOTIONS``. upper, ratio, fullness (P,): see ``Beat``."""

    numbers: np.ndarray
    distances: np.ndarray
    motion: np.ndarray
    upper: np.ndarray
    ratio: np.ndarray
    fullness: np.ndarray


@dataclass(frozen=True)
class CheckedCandidate:
    """Candidate that beats in the averaged equations. numbers: values of the variables (k,). slow: its beat. cycles:
    those of the full equations over ``duration``, by rainflow. distances: of these from the target, by each of ``METRICS``
    (3,). outcome: of the run. beats: True if it is one of those that beat. reason: of an early end of the run. beat_time,
    beat_values (n,): turning points of the signal over one beat, with the largest amplitude at that time in it at which the
    averaged equations have theirs."""

    numbers: np.ndarray
    slow: Beat
    cycles: LoadCycles
    distances: np.ndarray
    duration: float
    outcome: str
    beats: bool
    reason: str
    beat_time: np.ndarray = field(default_factory=lambda: np.empty(0))
    beat_values: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class DesignTrials:
    """Evaluation of the candidates of a machine, each from the same start.

    signal, direction: whose beat counts. inertia: True if averaged equations keep that of the bodies. tolerance: of
    integrations. metric: the column of the minimised distance. slope: of the Woehler line.
    """

    machine: Machine
    variables: tuple[Variable, ...]
    signal: str
    direction: str | None
    start: Mapping[str, Any]
    inertia: bool
    tolerance: float
    metric: int
    slope: float

    def candidate_machine(self, numbers: np.ndarray) -> Machine:
        """Return the machine of a candidate (k,). Raises ``InputError`` where its parts do not allow it."""
        return self.machine.with_values(values_at(self.machine, self.variables, numbers.tolist()))

    def beat(self, numbers: np.ndarray) -> Beat:
        """Return the beat of a candidate (k,)."""
        try:
            machine = self.candidate_machine(numbers)
        except InputError as error:
            return Beat("not-allowed", reason=error.explanation)
        return beat_of(machine, self.signal, self.direction, self.start, self.inertia, self.tolerance)

    def evaluate(self, numbers: np.ndarray, target: LoadCycles, report: Callable[[float], None]) -> Candidates:
        """Evaluate candidates (P, k)."""
        beats = list[Beat]()
        for k, row in enumerate(numbers):
            report(k / len(numbers))
            beats.append(self.beat(row))
        beat_distances = [
            spectrum_distances(b.cycles, target, self.slope) if b.motion == "modulated" else _NO_DISTANCE for b in beats
        ]
        return Candidates(
            numbers,
            np.array(beat_distances, float).reshape(-1, len(METRICS)),
            np.array([MOTIONS.index(b.motion) for b in beats], int),
            *(np.array([getattr(b, name) for b in beats], float) for name in ("upper", "ratio", "fullness")),
        )

    def values(self, shares: np.ndarray) -> np.ndarray:
        """Return values (P, k) at shares (P, k), 0 to 1, of the ranges."""
        return np.stack([v.value_at(shares[:, k]) for k, v in enumerate(self.variables)], axis=1)

    def shares(self, numbers: np.ndarray) -> np.ndarray:
        """Return the shares (k,) of values (k,) in their ranges."""
        return np.array([v.share(float(x)) for v, x in zip(self.variables, numbers, strict=True)])

    def optimise(
        self, start: np.ndarray, target: LoadCycles, evaluations: int, report: Callable[[float], None]
    ) -> tuple[np.ndarray, float]:
        """Search the best near a candidate (k,), and return it with its distance.

        J. A. Nelder and R. Mead, Computer Journal 7 (1965) 308-313.
        """
        from scipy.optimize import minimize

        begin, done = np.clip(self.shares(start), 0.0, 1.0), 0

        def objective(share: np.ndarray) -> float:
            nonlocal done
            report(min(done / evaluations, 1.0))
            done += 1
            beat = self.beat(self.values(share[None])[0])
            return spectrum_distances(beat.cycles, target, self.slope)[self.metric] if beat.motion == "modulated" else _FAR

        steps = np.where(begin > 1 - _SIMPLEX, -_SIMPLEX, _SIMPLEX)
        options = {
            "initial_simplex": np.vstack([begin, begin + np.diag(steps)]),
            "maxfev": evaluations, "xatol": _CLOSE, "fatol": _CLOSE,
        }  # fmt: skip
        solution = minimize(objective, begin, method="Nelder-Mead", bounds=[(0.0, 1.0)] * len(begin), options=options)
        return self.values(np.clip(solution.x, 0.0, 1.0)[None])[0], float(solution.fun)


def check_candidate(
    trials: DesignTrials, numbers: np.ndarray, target: LoadCycles, beats: int, work: Work, after: int = 0
) -> CheckedCandidate:
    """Run a candidate (k,) with the full equations, over a number of its beats after it repeats itself.

    after: beats that are left out before, which have been counted already.
    """
    slow = trials.beat(numbers)
    begin = slow.begin + after * slow.period
    settings = RunSettings(until=begin + beats * slow.period, tolerance=trials.tolerance)
    case = RunUpCase.of(trials.candidate_machine(numbers), trials.start, settings)
    *_, last = load_histories(case, machine_signal(case.machine, trials.signal, trials.direction), work)
    is_counted = last.time >= begin
    rows, _ = rainflow(last.values[is_counted]).group_by_range()
    far, cycles = np.array(spectrum_distances(rows, target, trials.slope)), replace(rows, means=np.zeros(len(rows.ranges)))
    duration, outcome = last.end_time - begin, None if last.verdict is None else last.verdict.outcome
    return CheckedCandidate(
        numbers, slow, cycles, far, duration, str(outcome), outcome in BEATING, last.failure or "",
        *_one_beat(slow, last.time[is_counted], last.values[is_counted]),
    )  # fmt: skip


def _one_beat(slow: Beat, time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the turning points (n,) of one beat, in time with that of the averaged equations."""
    is_second = (time >= time[0] + slow.period) & (time < time[0] + 2 * slow.period) if len(time) else np.empty(0, bool)
    if not is_second.any():
        return np.empty(0), np.empty(0)
    largest = time[is_second][np.abs(values[is_second]).argmax()]
    begin = largest - slow.time[slow.amplitude.argmax()]
    is_shown = (time >= begin) & (time <= begin + slow.period)
    return time[is_shown] - begin, values[is_shown]


def spectrum_distances(cycles: LoadCycles, target: LoadCycles, slope: float) -> tuple[float, float, float]:
    """Return the distances of a spectrum from the target by ``METRICS``, scaled to the target's number of cycles.

    The last one compares the damage of all cycles above an amplitude, with N proportional to S^-slope, as the cumulative one
    compares their number: both the total damage and the amplitudes that cause it have to agree.
    """
    if not cycles.total:
        return np.inf, np.inf, np.inf
    times = target.total / cycles.total
    return (
        amplitude_distance(cycles, target), frequency_distance(cycles, target, times),
        frequency_distance(damage_weighted_cycles(cycles, target, slope), damage_weighted_cycles(target, target, slope), times),
    )  # fmt: skip


def damage_weighted_cycles(cycles: LoadCycles, target: LoadCycles, slope: float) -> LoadCycles:
    """Return the cycles with their damages as counts, that of the target's largest amplitude being 1."""
    line = WoehlerLine(slope, 1.0, target.largest / 2, slope)
    return replace(cycles, counts=line.damages(cycles))
