"""A candidate in the full equations: its spectrum, counted as ``load-spectrum`` counts it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.fatigue.counted_cycles import Cycles
from wucht.fatigue.rainflow_counting import rainflow
from wucht.studies.exciter_design.design_trials import Trials, distances
from wucht.studies.exciter_design.slow_beats import Beat
from wucht.studies.load_spectrum.prepare import prepare as prepare_load
from wucht.studies.load_spectrum.run import run as run_load
from wucht.studies.load_spectrum.spec import LoadSpectrum

BEATING = (Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED)


@dataclass(frozen=True)
class Checked:
    """A candidate that beats in the averaged equations. numbers: values of the variables (k,). slow: its beat. ranges, counts
    (m,): rainflow cycles of the full equations over ``duration``. distances: of these from the target, by each of ``METRICS``
    (3,). outcome: what becomes of the exciter. beats: whether it is one of those that beat. why: the run ended early."""

    numbers: np.ndarray
    slow: Beat
    ranges: np.ndarray
    counts: np.ndarray
    distances: np.ndarray
    duration: float
    outcome: str
    beats: bool
    why: str

    @property
    def cycles(self) -> Cycles:
        """Of the full equations."""
        return Cycles(self.ranges, np.zeros(len(self.ranges)), self.counts)


def checked(trials: Trials, numbers: np.ndarray, target: Cycles, beats: int, work: Work) -> Checked:
    """Run a candidate (k,) with the full equations, over a number of its beats after it repeats itself."""
    slow, rig = trials.beat(numbers), trials.rig
    end = slow.begin + beats * slow.period
    asked = LoadSpectrum(
        signal=rig.signal, direction=rig.direction, until=end, after=slow.begin, start=rig.start, tolerance=rig.tolerance
    )
    plan = prepare_load(asked, trials.of(numbers))
    *_, last = run_load(plan, work)
    cycles = rainflow(last.values[last.time >= slow.begin])
    rows, _ = cycles.by_range()
    far = np.array(distances(rows, target, trials.slope))
    duration, outcome = last.end_time - slow.begin, None if last.verdict is None else last.verdict.outcome
    beats_too = outcome in BEATING
    return Checked(numbers, slow, rows.ranges, rows.counts, far, duration, str(outcome), beats_too, last.failure or "")
