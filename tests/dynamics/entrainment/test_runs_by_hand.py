"""Runs that are judged, the senses in which bodies turn, how long runs last, and locked motions against their closed form."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase, SweptParameter, swept_parameter
from wucht.dynamics.entrainment.locked_motions import LockedMotion, LockedMotions, bodies_with_phase
from wucht.dynamics.entrainment.runs_from_start import RunFromStart, RunsFromStart, capture_band, senses_of, values_to_run
from wucht.dynamics.verdicts.locking import LockingAssessment
from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine

W, SLOPE, UNBALANCE, AMPLITUDE = 2 * math.pi, 1e-5, 0.1 * 0.01, 1e-3
TORQUE = UNBALANCE * AMPLITUDE * W**2 / 2


def pair(first: float = 12.0, second: float = 13.0, **more: Any) -> Any:
    """Two exciters on a carrier, and a pendulum about the second one."""
    rotor = {"kind": "rotor", "mass": 1.0, "unbalance": 1e-3, "inertia": 1e-3}
    ball = {"kind": "pendulum", "name": "p", "about": "e2", "mass": 0.05, "length": 0.1, "damping": 0.01}
    drives = [
        {"on": name, "kind": "linear", "slope": 1e-2, "no_load_speed": speed} for name, speed in (("e1", first), ("e2", second))
    ]
    return machine_from({
        "carrier": {"mass": 5.0, "directions": "x", "stiffness": 50.0, "damping": 1.0},
        "bodies": [rotor | {"name": "e1"}, rotor | {"name": "e2"}, ball], "drives": drives,
    } | more)  # fmt: skip


def runs(machine: Any, senses: dict[str, float] | None = None, rate: float | None = None, until: float | None = None) -> Any:
    case: Any = SimpleNamespace(machine=machine, until=until)
    return RunsFromStart(case, senses, rate)


def locking(first: float, second: float, locked: bool | None = True, creep: float = 0.0, change: float = 0.0) -> Any:
    return LockingAssessment(
        SimpleNamespace(is_locked=locked),  # type: ignore[arg-type]
        {"e1": first, "e2": second}, {"e2": 0.5}, (3.0, 4.0), {"e1": first + 0.5, "e2": second}, change, creep,
        SimpleNamespace(), {},  # type: ignore[arg-type]
    )  # fmt: skip


def judged(means: Any, senses: dict[str, float] | None = None, failure: str | None = None, angle: Any = None) -> RunFromStart:
    machine, last = pair(12.0, -13.0), SimpleNamespace(end_time=9.0, end_state=np.arange(3.0), failure=failure)
    half = SimpleNamespace(time=np.array([4.0, 7.0, 8.0]), angle=np.array([0.0, 0.0, 0.0] if angle is None else angle))
    observation = SimpleNamespace(main=SimpleNamespace(last=lambda share: half if share == 0.5 else None))
    run: RunFromStart = runs(machine, senses)._judge(machine, 0.25, last, observation, means)
    assert (run.value, run.end_time, run.end_state.tolist(), run.free_speed) == (0.25, 9.0, [0, 1, 2], pytest.approx(12.0))
    return run


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_rotor_that_hardly_turns_has_a_mean_speed_with_its_sign(sense: float) -> None:
    run = judged(None, angle=[sense * 1.0, sense * 7.0, sense * 3.0])
    assert run.mean_speed == pytest.approx(sense * 0.5) and run.window == (4.0, 8.0)
    assert not run.is_entrained and not run.speeds


def test_a_run_that_failed_has_no_speed() -> None:
    run = judged(locking(12.0, -12.0), failure="it burst")
    assert run.failure == "it burst" and math.isnan(run.mean_speed) and not run.is_entrained


@pytest.mark.parametrize(
    ("locked", "creep", "senses", "entrained"),
    [
        (True, 0.9e-4, None, True), (True, 1.1e-4, None, False), (False, 0.0, None, False), (True, 0.0, (1.0, -1.0), True),
        (True, 0.0, (1.0, 1.0), False), (True, 0.0, (-1.0, -1.0), False),
    ],
)  # fmt: skip
def test_entrained_is_what_is_locked_rests_and_turns_as_it_should(
    locked: bool, creep: float, senses: tuple[float, float] | None, entrained: bool
) -> None:
    run = judged(locking(12.5, -12.5, locked, creep), senses and dict(zip(("e1", "e2"), senses, strict=True)))
    assert run.is_entrained is entrained and (run.creep, run.window) == (creep, (3.0, 4.0))
    assert run.mean_speed == (12.5 if entrained else 13.0), "whole periods of what has none in common are not averaged over"
    assert run.speeds == {"e1": 12.5, "e2": -12.5} and run.phases == {"e2": 0.5}


@pytest.mark.parametrize(
    ("means", "periods", "decided"),
    [
        (locking(12.0, -12.0, None), 100.0, False), (locking(12.0, -12.0, None), 20_001.0, True),
        (locking(12.0, -12.0, True, 1.1e-4), 100.0, False), (locking(12.0, -12.0, True, 0.9e-4), 100.0, True),
        (locking(2.0, -12.0, False, 1.0, 0.23), 100.0, True), (locking(2.0, -12.0, False, 0.0, 0.25), 100.0, False),
    ],
)  # fmt: skip
def test_what_decides_a_run(means: Any, periods: float, decided: bool) -> None:
    """A phase at rest; else a speed that changes by less than 2 % of the largest, though that turns clockwise; or the end."""
    of = runs(pair())
    assert of._is_decided(periods * of.period, means) is decided


def test_how_long_a_run_lasts() -> None:
    """At least 200 periods and 25 decay times, at most 20,000 periods, after the end of the schedules; or as requested."""
    of = runs(pair())
    assert of.period == pytest.approx(2 * math.pi / 13.0)
    assert of.duration == pytest.approx(200 * of.period)
    assert runs(pair(), rate=0.5).duration == pytest.approx(200 * of.period + 50.0)
    assert runs(pair(), rate=1e-9).duration == pytest.approx(20_000 * of.period)
    assert runs(pair(), rate=0.5, until=3.0).duration == 3.0
    ramp = {"parameter": "drives.e1.slope", "points": [[0.0, 1e-2], [7.0, 2e-2]]}
    assert runs(pair(schedules=[ramp])).duration == pytest.approx(200 * of.period + 7.0)
    grids = list(of._grids(1.0, 1.0 + 200 * of.period * 2.5))
    assert len(grids) == 1 and grids[0] == pytest.approx(1.0 + 200 * of.period * 2.5 * np.arange(4) / 3)
    many = list(of._grids(0.0, 200 * of.period * 1500))
    assert [len(g) for g in many] == [1001, 501] and many[0][-1] == many[1][0] and many[1][-1] == 200 * of.period * 1500


@pytest.mark.parametrize(
    ("entrained", "speeds", "initial", "senses"),
    [
        (True, (12.0, -12.0), (-1.0, 1.0), (1.0, -1.0)), (False, (12.0, -12.0), (-1.0, 1.0), (-1.0, 1.0)),
        (False, (12.0, 12.0), (0.0, 0.0), (1.0, -1.0)), (False, (12.0, 12.0), (0.0, 2.0), (1.0, 1.0)),
    ],
)  # fmt: skip
def test_bodies_turn_as_entrained_as_at_the_start_or_as_driven(
    entrained: bool, speeds: tuple[float, float], initial: tuple[float, float], senses: tuple[float, float]
) -> None:
    machine = pair(12.0, -13.0)
    state = np.zeros(len(machine.state_names))
    for name, speed in zip(("e1", "e2"), initial, strict=True):
        state[machine.row(machine.body(name).coordinate.velocity)] = speed
    run = RunFromStart(0.0, 1.0, 1.0, state, is_entrained=entrained, speeds=dict(zip(("e1", "e2"), speeds, strict=True)))
    first, second = senses
    assert senses_of(machine, state, run) == {"e1": first, "e2": second, "p": second}


def entrained(value: float, *bands: tuple[float, float]) -> RunFromStart:
    return RunFromStart(value, 1.0, 1.0, np.zeros(1), is_entrained=any(a <= value <= b for a, b in bands))


def test_the_band_of_the_value_comes_before_the_widest_one() -> None:
    scan = [entrained(float(v), (1.0, 2.0), (4.0, 8.0)) for v in range(11)]
    of_value, widest = capture_band(scan, 1.5), capture_band(scan, 3.0)
    assert of_value is not None and widest is not None
    assert (of_value.brackets, of_value.islands) == (((1.0, 0.0), (2.0, 3.0)), ((4.0, 8.0),))
    assert (widest.brackets, widest.edges, widest.islands) == (((4.0, 3.0), (8.0, 9.0)), (3.5, 8.5), ((1.0, 2.0),))
    assert capture_band([entrained(0.0), entrained(1.0)], 0.0) is None
    whole = capture_band([entrained(0.0, (0.0, 1.0)), entrained(1.0, (0.0, 1.0))], 0.0)
    assert whole is not None and whole.edges == (None, None)


def test_probes_lie_to_both_sides_of_each_edge() -> None:
    """Eight to each side, over the distance of two values of the scan."""
    scan = [entrained(float(v), (3.0, 6.0)) for v in range(11)]
    later = list(values_to_run(scan, 4.0, 1.5))
    expected = [
        edge + side * (k + 0.5) / 8 for edge in (2.5, 6.5) for k in range(8) for side in (-1, 1)
    ]  # 1.5: the brackets of the scan are narrow enough
    assert later == pytest.approx(expected)


def shaken(speed: float) -> Any:
    machine = load_machine("sperling-vibration/figure-2a").with_values({"drive.no_load_speed": speed})
    return EntrainmentCase.of(machine, swept_parameter(machine), {}, 25)


@pytest.mark.parametrize(("sense", "time"), [(1.0, 0.0), (1.0, 0.3), (-1.0, 0.3)])
def test_the_phase_of_a_locked_motion(sense: float, time: float) -> None:
    """k (W - w) = T sin(p) to first order, as sigma phi - w t, whenever the period begins."""
    case, phase = shaken(sense * 7.0), math.asin(SLOPE * (7.0 - W) / TORQUE)
    motions = LockedMotions(case, {"rotor": sense}, time)
    machine = case.machine
    guess = np.zeros(len(machine.state_names))
    guess[machine.row(machine.rotor.coordinate.position)] = sense * (W * time + phase)
    guess[machine.row(machine.rotor.coordinate.velocity)] = sense * W
    for row, name in enumerate(machine.state_names):
        if name.startswith("carrier."):
            guess[row] = case.initial[row]
    shake = AMPLITUDE * math.cos(W * time)
    guess[machine.row(machine.carrier[0].position)] = shake
    motion = motions.motion(sense * 7.0, guess, W)
    assert math.remainder(float(motion.phases[0]) - phase, 2 * math.pi) == pytest.approx(0.0, abs=5e-3)
    assert (motion.value, motion.speed) == (sense * 7.0, pytest.approx(W, rel=1e-9)) and motion.stable
    inertia, period = machine.values["rotor.inertia"], 2 * math.pi / W
    roots = np.roots([inertia, SLOPE, TORQUE * math.cos(phase)])
    assert motion.multiplier == pytest.approx(math.exp(roots.real.max() * period), abs=2e-3)


def test_which_bodies_have_a_phase() -> None:
    assert bodies_with_phase(pair()) == ["e2", "p"]
    assert bodies_with_phase(shaken(7.0).machine) == ["rotor"]


def motion_at(value: float) -> LockedMotion:
    orbit: Any = SimpleNamespace(state=np.array([2 * value, 3.0]))
    return LockedMotion(value, np.array([value]), 1.0, 0.5, orbit)


def following(end: float) -> Any:
    """Motions up to a value, whose states are linear in it. Each guess is kept."""
    of = object.__new__(LockedMotions)
    of.advance, of.guesses = np.array([1.0, 0.0]), []  # type: ignore[attr-defined]

    def motion(value: float, guess: np.ndarray, speed: float, most_steps: int) -> LockedMotion:
        of.guesses.append((value, guess.tolist()))  # type: ignore[attr-defined]
        if abs(value) > end:
            raise WuchtError("none")
        return motion_at(value)

    of.motion = motion  # type: ignore[method-assign]
    return of


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_where_locked_motions_end(sense: float) -> None:
    goals = [sense * x for x in (0.125, 0.25, 0.375, 0.5)]
    of = following(0.3)
    *_, (motions, end) = of.follow(motion_at(0.0), goals, 1e-3, Work())
    assert [m.value for m in motions] == goals[:2]
    assert end == pytest.approx(sense * 0.3, abs=1e-3)
    assert of.guesses[0] == (goals[0], [0.0, 3.0]), "nothing to extrapolate from"
    assert of.guesses[1] == (goals[1], pytest.approx([2 * goals[1], 3.0])), "to the next motion on a straight line"
    *_, (motions, end) = following(1.0).follow(motion_at(0.0), goals, 1e-3, Work())
    assert [m.value for m in motions] == goals and end is None


def test_a_motion_that_has_jumped_or_is_unstable_does_not_continue() -> None:
    of, beside = following(10.0), motion_at(0.0)
    assert of._continue_motion(beside, 0.49, None) is not None and of._continue_motion(beside, 0.51, None) is None
    assert of._continue_motion(beside, -0.51, None) is None
    assert of._continue_motion(beside, 2 * math.pi - 0.2, None) is not None, "whole turns are none"
    of.motion = lambda *_: LockedMotion(0.1, np.array([0.0]), 1.0, 1.0, beside.orbit)
    assert of._continue_motion(beside, 0.1, None) is None


def test_values_of_a_swept_parameter() -> None:
    both = SweptParameter("detuning", "rad/s", "", -3.0, {"a": (2.0, -0.5), "b": (-7.0, -0.5)})
    assert both.size == 7.0 and both.values(4.0) == {"a": 0.0, "b": -9.0}
    assert SweptParameter("c", "", "", -30.0, {"c": (0.0, 1.0)}).size == 30.0
    machine: Any = SimpleNamespace(shaking_frequency=-0.5)
    assert both.widest(machine) == (-350.0, 350.0)
    machine = SimpleNamespace(shaking_frequency=-9.0)
    assert both.widest(machine) == (-450.0, 450.0)
    assert SweptParameter("drive.slope", "", "", 1.0, {"drive.slope": (0.0, 1.0)}).widest(machine) is None
    assert SweptParameter("carrier.motion.amplitude", "m", "", 0.5, {}).widest(machine) == (0.0, 5.0)
