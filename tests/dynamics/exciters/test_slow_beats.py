"""A beat of the averaged equations, against its orbit, against its own run counted by rainflow, and the full equations."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from wucht.dynamics.exciters.design_trials import DesignTrials, spectrum_distances
from wucht.dynamics.exciters.slow_beats import Beat, beat_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import machine_signal
from wucht.dynamics.run_ups.observed_loads import load_histories
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.sampling.searches import variables_of
from wucht.dynamics.work import Work
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.counting import rainflow
from wucht.fatigue.cumulative_spectra import amplitude_distance
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

MACHINE = load_machine("practice/exciter")
BEATS = 40


def found_beat(machine: Machine = MACHINE, signal: str = "displacement") -> Beat:
    return beat_of(machine, signal, None, {}, True, 1e-9)


def counted(signal: str, beat: Beat, model: Literal["full", "slow"]) -> tuple[LoadCycles, float]:
    """Rainflow cycles of a run over a number of beats, and its time."""
    settings = RunSettings(until=beat.begin + BEATS * beat.period, model=model, inertia=True if model == "slow" else None)
    case = RunUpCase.of(MACHINE, {}, settings)
    with np.errstate(all="ignore"):  # at rest nothing is fast: 0/0; the runner does so too
        *_, last = load_histories(case, machine_signal(case.machine, signal, None), Work())
    return rainflow(last.values[last.time >= beat.begin]), BEATS * beat.period


@pytest.fixture(scope="module")
def beat() -> Beat:
    return found_beat()


def test_it_is_the_orbit_of_the_branch(beat: Beat) -> None:
    """Period and amplitudes of the orbit by collocation, tests/validation/test_exciter.py."""
    assert beat.motion == "modulated"
    assert beat.period == pytest.approx(1.1285553, rel=1e-5)
    assert beat.amplitude.min() == pytest.approx(0.7797988e-3, rel=1e-4)
    assert beat.upper == pytest.approx(1.7780748e-3, rel=1e-4)
    assert beat.ratio == pytest.approx(0.7797988 / 1.7780748, rel=2e-4)
    assert 0 < beat.fullness < 1


@pytest.mark.slow
@pytest.mark.parametrize("signal", ["displacement", "bearing-force", "acceleration"])
def test_its_cycles_are_those_of_its_own_run(signal: str) -> None:
    """As many a unit of time to 0.1 %, and amplitudes to 0.6 % of the largest: rainflow pairs neighbours that differ."""
    found = found_beat(signal=signal)
    cycles, time = counted(signal, found, "slow")
    assert found.cycles.total / found.period == pytest.approx(cycles.total / time, rel=1e-3)
    assert amplitude_distance(cycles, found.cycles) < 0.006
    assert cycles.largest / 2 == pytest.approx(found.upper, rel=1e-3)


def test_the_full_equations_are_near(beat: Beat) -> None:
    cycles, time = counted("displacement", beat, "full")
    assert amplitude_distance(cycles, beat.cycles) < 0.02
    assert cycles.total / time == pytest.approx(beat.cycles.total / beat.period, rel=0.05)


def test_without_a_beat_it_says_what_is() -> None:
    """Below and above the range in which the modulated motion exists; and a machine that its parts do not allow."""
    for slope in (1e-4, 3.5e-3):
        assert found_beat(MACHINE.with_values({"drive.slope": slope})).motion == "steady"
    vary = {"p1.mass": {"of": None, "range": [0.1, 2.0]}}
    trials = DesignTrials(MACHINE, variables_of(MACHINE, vary, False), "displacement", None, {}, True, 1e-9, 0, 5.0)
    target = LoadCycles(np.ones(1), np.zeros(1), np.ones(1))
    tried = trials.evaluate(np.array([[-1.0], [1.0]]), target, lambda share: None)
    assert tried.motion.tolist() == [4, 0]
    assert np.isnan(tried.distances[0]).all() and np.isfinite(tried.distances[1]).all()


def test_each_distance_sees_what_it_is_for() -> None:
    """Half as many of the larger cycles: amplitudes off by 0.25 of 2, counts by 1/4, damages (S^3) by 0.25 (8 - 1)/4.5."""
    target = LoadCycles(np.array([2.0, 4.0]), np.zeros(2), np.array([1.0, 1.0]))
    fewer = LoadCycles(np.array([2.0, 4.0]), np.zeros(2), np.array([3.0, 1.0]))
    amplitude, cumulative, damage = spectrum_distances(fewer, target, 3.0)
    assert amplitude == pytest.approx(0.25 * 1 / 2)
    assert cumulative == pytest.approx(0.25)
    assert damage == pytest.approx(0.25 * 8 / 4.5)
    assert spectrum_distances(target, target, 3.0) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
