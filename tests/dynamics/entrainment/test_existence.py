"""The band of existence of a rotor on a carrier with prescribed vibration, by hand: (21) and (25) of paper 001, and the decay.

On a carrier that vibrates as a cos(w t), a rotor with the unbalance m r and the moment of inertia J about its axis, on a motor
of the slope k, has the averaged equation J p'' + k p' = k (W - w) - T sin(p), T = m r a w^2/2, with its phase p.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.entrainment import existence as existence_module
from wucht.dynamics.entrainment.entrainment_case import AMPLITUDE as SHAKEN
from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase, swept_parameter
from wucht.dynamics.entrainment.existence import (
    Continuation,
    Existence,
    StableRange,
    existence,
    range_around,
    threshold,
)
from wucht.dynamics.entrainment.runs_from_start import RunFromStart
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

W, SLOPE, UNBALANCE, AMPLITUDE = 2 * math.pi, 1e-5, 0.1 * 0.01, 1e-3
TORQUE = UNBALANCE * AMPLITUDE * W**2 / 2


def machine(speed: float) -> Machine:
    return load_machine("sperling-vibration/figure-2a").with_values({"drive.no_load_speed": speed})


def case_of(speed: float) -> EntrainmentCase:
    return EntrainmentCase.of(machine(speed), swept_parameter(machine(speed)), {}, 25)


def not_entrained(case: EntrainmentCase) -> RunFromStart:
    return RunFromStart(case.parameter.nominal_value, 1.0, 1.0, case.initial)


def existing(speed: float, sense: float) -> Existence:
    case = case_of(speed)
    return existence(case, not_entrained(case), {"rotor": sense}, Work())


@pytest.mark.parametrize("speed", [5.0, 6.0, 7.9])
def test_the_slowest_decay(speed: float) -> None:
    """J s^2 + k s + T cos(p) = 0 with sin(p) = k (W - w)/T."""
    found, inertia = existing(speed, 1.0), machine(speed).values["rotor.inertia"]
    cosine = math.sqrt(1 - (SLOPE * (speed - W) / TORQUE) ** 2)
    roots = np.roots([inertia, SLOPE, TORQUE * cosine])
    assert found.slowest_rate == pytest.approx(-roots.real.max(), rel=1e-9)
    assert found.slowest_rate > 0


def test_outside_the_band_the_decay_is_that_well_inside() -> None:
    """A tenth of the band from its end."""
    beyond, width = existing(20.0, 1.0), TORQUE / SLOPE
    assert beyond.slowest_rate == pytest.approx(existing(W + 0.8 * width, 1.0).slowest_rate, rel=1e-6)
    assert beyond.phases == {}


@pytest.mark.parametrize("speed", [5.0, 7.9])
def test_clockwise_it_is_the_mirror_image(speed: float) -> None:
    forward, backward = existing(speed, 1.0), existing(-speed, -1.0)
    assert forward.band is not None
    assert backward.band is not None
    width = TORQUE / SLOPE
    assert forward.band.ends == pytest.approx((W - width, W + width), rel=1e-9)
    assert backward.band.ends == pytest.approx((-W - width, -W + width), rel=1e-9)
    assert backward.slowest_rate == pytest.approx(forward.slowest_rate, rel=1e-9)
    assert backward.phases["rotor"] == pytest.approx(forward.phases["rotor"], rel=1e-9), "in its sense"


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_least_amplitude_against_the_drive(sense: float) -> None:
    """(25): k |W - w| = m r a w^2/2."""
    case = case_of(5.0 * sense)
    found = existence(case, not_entrained(case), {"rotor": sense}, Work())
    assert threshold(case, found, Work()) == pytest.approx(2 * SLOPE * (W - 5.0) / (UNBALANCE * W**2), rel=1e-9)


def test_of_several_amplitudes_the_least_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of ranges that reach the largest amplitude. One that ends before does not count; where none reaches it, more is tried."""
    tried: list[float] = []

    class Ranges:
        def __init__(self, _: Any) -> None:
            pass

        def branches(self, values: Iterable[float], *_: Any) -> None:
            tried.extend(values)

        def stable_ranges(self, _: Any) -> list[Any]:
            def stable(low: float, kind: str) -> Any:
                return StableRange(0, (low, 9.0), ("fold", kind), np.arange(3))

            reached = [stable(low, "range") for low in (3.0, 2.0, 2.5)]
            return [stable(1.0, "fold"), *(reached if len(tried) > 1 else ())]

    case = case_of(5.0)
    found = existence(case, not_entrained(case), {"rotor": 1.0}, Work())
    monkeypatch.setattr(existence_module, "Continuation", Ranges)
    assert threshold(case, found, Work()) == 2.0
    assert tried == pytest.approx([AMPLITUDE, 2 * AMPLITUDE])


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("bands", "expected"),
    [
        (((4.9, 5.1), (3.0, 7.0), (4.5, 5.5)), (3.0, 7.0)),  # all hold the machine's value, 5: the widest
        (((1.0, 4.0), (5.5, 6.0), (8.0, 9.0)), (5.5, 6.0)),  # none does: the nearest, above the value
        (((0.5, 1.0), (2.0, 4.75), (5.5, 9.0)), (2.0, 4.75)),  # and below it
        (((1.0, 4.9), (4.95, 5.05), (5.1, 9.0)), (4.95, 5.05)),  # one does, however narrow
    ],
)
def test_of_several_ranges_that_of_the_machine_counts(
    turned: bool, bands: Any, expected: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In which it is, or the nearest; of several the widest."""
    ranges = bands[:: -1 if turned else 1]

    class Ranges:
        def __init__(self, _: Any) -> None:
            pass

        def branches(self, *_: Any) -> list[Any]:
            return [
                EquilibriumBranch(
                    np.array([[0.1] * 3, [W] * 3, [low, (low + high) / 2, high]]), np.empty((0, 3)), ("",) * 3, ("", "")
                )
                for low, high in ranges
            ]

        def stable_ranges(self, _: Any) -> list[StableRange]:
            return [StableRange(k, ends, ("fold", "fold"), np.arange(3)) for k, ends in enumerate(ranges)]

    case = case_of(5.0)
    monkeypatch.setattr(existence_module, "Continuation", Ranges)
    band = existence(case, not_entrained(case), {"rotor": 1.0}, Work()).band
    assert band is not None
    assert band.ends == expected


def case_along(name: str, own: float, *limits: float) -> Any:
    return SimpleNamespace(
        parameter=SimpleNamespace(name=name, nominal_value=own),
        limits=limits,
        machine=SimpleNamespace(shaken_coordinate=object()),
    )


def band(low: float, high: float, kind: str = "fold") -> StableRange:
    return StableRange(0, (low, high), (kind, "range"), np.array([0]))


def test_the_range_about_a_band() -> None:
    first, largest, margin = 0.5, 3.0, 0.2
    assert range_around(case_along(SHAKEN, 3.0, 0.0, 50.0), band(2.0, 9.0)) == (first * 2.0, largest * 3.0)
    assert range_around(case_along(SHAKEN, 1.0, 0.0, 50.0), band(2.0, 9.0)) == (first * 2.0, largest * 2.0)
    assert range_around(case_along(SHAKEN, 1.0, 0.0, 50.0), band(2.0, 9.0, "range")) == (first * 2.0, largest * 1.0)
    assert range_around(case_along("slope", 3.0, -90.0, 90.0), band(2.0, 5.0)) == (2.0 - 3 * margin, 5.0 + 3 * margin)
    assert range_around(case_along("slope", 7.0, -90.0, 90.0), band(2.0, 5.0)) == (2.0 - 5 * margin, 7.0 + 5 * margin)
    assert range_around(case_along("slope", 7.0, 1.9, 7.1), band(2.0, 5.0)) == (1.9, 7.1)
    assert range_around(case_along("slope", -7.0, -90.0, 90.0), None) == (-14.0, 0.0)
    assert range_around(case_along("slope", 0.0, -90.0, 110.0), None) == (-2.0, 2.0)


def test_the_threshold_along_the_amplitude_is_where_its_band_begins() -> None:
    def of(found: StableRange | None) -> float | None:
        return threshold(case_along(SHAKEN, 1.0, 0.0, 9.0), Existence(equations=object(), band=found), Work())  # type: ignore[arg-type]

    assert (of(band(2.0, 9.0)), of(band(2.0, 9.0, "range")), of(None)) == (2.0, None, None)
    assert threshold(case_along(SHAKEN, 1.0, 0.0, 9.0), Existence(band=band(2.0, 9.0)), Work()) is None


def branch_of(values: list[float], stable: list[bool], kinds: dict[int, str], closed: bool = False) -> EquilibriumBranch:
    """Of one phase that falls by 1 a point."""
    names = tuple(kinds.get(k, "") for k in range(len(values)))
    exponents = np.where(stable, -1.0 + 0.0j, 1.0)[None, :]
    unknowns, end = np.array([-np.arange(float(len(values))), values]), "it is closed" if closed else "the range ends"
    branch = EquilibriumBranch(unknowns, exponents, names, (end, end))
    assert branch.stable.tolist() == stable
    return branch


def following() -> Continuation:
    """Without equations of its own: distances of phases."""
    made = Continuation.__new__(Continuation)
    made.equations = SimpleNamespace(distance=lambda a, b: np.abs(a - b).max(axis=-1))  # type: ignore[assignment]
    return made


def test_a_stable_stretch_ends_at_the_special_point_beside_it() -> None:
    """A fold at 4, from which the branch comes back unstable; at the other end the range ends."""
    one = branch_of([1.0, 2.0, 3.0, 4.0, 3.5, 2.5], [True, True, True, True, False, False], {3: "fold"})
    two = branch_of([9.0, 8.0, 7.0, 6.0, 5.0, 4.0], [False, True, True, True, True, True], {1: "hopf"})
    first, second = following().stable_ranges([one, two])
    assert (first.branch, first.ends, first.kinds) == (0, (1.0, 4.0), ("range", "fold"))
    assert first.points.tolist() == [0, 1, 2]
    assert (second.branch, second.ends, second.kinds) == (1, (4.0, 8.0), ("range", "hopf"))
    assert second.points.tolist() == [2, 3, 4, 5]


def test_the_end_of_a_short_open_branch_is_not_beside_its_begin() -> None:
    short = branch_of([9.0, 8.0, 7.0, 6.0], [False, True, True, True], {1: "hopf"})
    (stable,) = following().stable_ranges([short])
    assert (stable.ends, stable.kinds) == ((6.0, 8.0), ("range", "hopf"))


def test_a_stable_stretch_of_a_closed_branch_is_not_cut_where_it_begins() -> None:
    values = [3.0, 4.0, 5.0, 4.0, 3.0, 2.0, 1.0, 2.0, 3.0]
    stable = [True, True, True, False, False, False, True, True, True]
    (range_,) = following().stable_ranges([branch_of(values, stable, {2: "fold", 6: "fold"}, closed=True)])
    assert (range_.ends, range_.kinds) == ((1.0, 5.0), ("fold", "fold"))
    assert range_.points.tolist() in ([7, 0, 1], [7, 8, 1])


def test_without_a_special_point_the_growth_beyond_says_how_stability_ends() -> None:
    for beyond, kind in ((0.1 + 0.0j, "fold"), (0.1 + 2.0j, "hopf")):
        one = branch_of([1.0, 2.0, 3.0], [True, True, False], {})
        one.exponents[0, 2] = beyond
        (stable,) = following().stable_ranges([one])
        assert (stable.ends[1], stable.kinds[1]) == (2.0, kind)


def test_an_equilibrium_lies_on_a_branch_between_its_points() -> None:
    """At 2.25 between points of phases -1 and -2 at 2 and 3; the step is 0.05; where the value stays, at its point."""
    one, on = branch_of([1.0, 2.0, 3.0, 3.0], [True] * 4, {}), following()
    assert on.passes(one, np.array([-1.25]), 2.25) and on.passes(one, np.array([-1.29]), 2.25)
    assert not on.passes(one, np.array([-1.31]), 2.25) and not on.passes(one, np.array([-1.75]), 2.25)
    assert on.passes(one, np.array([0.0]), 1.0) and not on.passes(one, np.array([0.0]), 0.99)
    assert on.passes(one, np.array([-2.0]), 3.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_below_the_band_the_decay_is_that_well_inside(sense: float) -> None:
    beyond, width = existing(1.0 * sense, sense), TORQUE / SLOPE
    assert beyond.slowest_rate == pytest.approx(existing((W - 0.8 * width) * sense, sense).slowest_rate, rel=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_values_at_which_equilibria_are_searched(sense: float) -> None:
    """The nominal one and the speed of the vibration in the rotor's sense; of a given range nine values besides."""
    case = case_of(5.0)
    assert existence_module._values(case, {"rotor": sense}) == [5.0, sense * W]
    given: Any = SimpleNamespace(machine=case.machine, parameter=case.parameter, limits=(4.0, 8.0), range=(4.0, 8.0))
    expected = [5.0, *([W] if sense > 0 else []), 4.0, 4.5, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0]
    assert existence_module._values(given, {"rotor": sense}) == pytest.approx(expected)
    shaken = SimpleNamespace(name=SHAKEN, nominal_value=2.0)
    along: Any = SimpleNamespace(machine=case.machine, parameter=shaken, limits=(0.0, 10.0), range=None)
    assert existence_module._values(along, {"rotor": sense}) == [2.0, 4.0, 8.0]
    detuned: Any = SimpleNamespace(
        machine=case.machine, parameter=SimpleNamespace(name="detuning", nominal_value=3.0), limits=(-5.0, 5.0), range=None
    )
    assert existence_module._values(detuned, {"rotor": sense}) == [3.0, 0.0]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_motors_need_no_torque_at_the_mean_speed_of_the_others(sense: float) -> None:
    """Three exciters, of which the first one's no-load speed is swept: the others turn at 9 and 11 rad/s, in magnitude."""
    rotors = [SimpleNamespace(name=name) for name in "abc"]
    machine: Any = SimpleNamespace(
        rotors=rotors, rotor=rotors[0], shaking_frequency=None, values={"a.v": 7.0, "b.v": 9.0, "c.v": -11.0}
    )
    case: Any = SimpleNamespace(
        machine=machine, parameter=SimpleNamespace(name="a.v", nominal_value=7.0), limits=(-50.0, 50.0), range=None
    )
    patch = pytest.MonkeyPatch()
    with patch.context() as context:
        context.setattr(existence_module, "no_load_speed", lambda _, rotor: f"{rotor.name}.v")
        assert existence_module._values(case, {"a": sense, "b": 1.0, "c": -1.0}) == [7.0, sense * 10.0]
        context.setattr(existence_module, "no_load_speed", lambda _, rotor: "a.v" if rotor is rotors[0] else None)
        machine.rotors = rotors[:1]
        assert existence_module._values(case, {"a": -sense}) == list(dict.fromkeys([7.0, -sense * 7.0]))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_averaged_state_of_a_state_of_the_machine(sense: float) -> None:
    """The phase is sigma phi less that of the vibration at this time."""
    case = case_of(5.0)
    equations = existence(case, not_entrained(case), {"rotor": sense}, Work()).equations
    assert equations is not None
    of, state = case.machine, np.zeros(len(case.machine.state_names))
    state[of.row(of.rotor.coordinate.position)] = sense * (W * 3.0 + 0.5)
    averaged = dict(zip(equations.names, equations.state_at(of, 3.0, state, 6.0).tolist(), strict=True))
    assert {name: value for name, value in averaged.items() if name.endswith("phase")} == {"rotor.phase": pytest.approx(0.5)}
    assert averaged["rotor.speed"] == pytest.approx(6.0)
    states = np.array([[0.5, 0.1], [6.0, 7.0]])
    ordered = states if equations.names[0].endswith("phase") else states[::-1]
    assert equations.speed(ordered).tolist() == [6.0, 7.0]
    assert equations.wrap_phases(np.where(equations.phases, 3 * math.pi + 0.5, 9.0)).tolist() == pytest.approx(
        np.where(equations.phases, -math.pi + 0.5, 9.0).tolist()
    )
    assert equations.wrap_phases(np.where(equations.phases, -math.pi, 9.0)).max() == 9.0
    assert abs(equations.wrap_phases(np.where(equations.phases, -math.pi, 9.0)).min()) == pytest.approx(math.pi)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_near_an_edge_the_slower_of_two_decays_counts(sense: float) -> None:
    """There both are real."""
    width, inertia = TORQUE / SLOPE, machine(5.0).values["rotor.inertia"]
    cosine = 0.1 * SLOPE**2 / (4 * inertia * TORQUE)
    found = existing(sense * (W + width * math.sqrt(1 - cosine**2)), sense)
    roots = np.roots([inertia, SLOPE, TORQUE * cosine])
    assert not roots.imag.any()
    assert found.slowest_rate == pytest.approx(-roots.real.max(), rel=1e-3)


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("begin", range(8))
def test_the_edges_of_a_closed_branch_do_not_depend_on_where_it_begins(begin: int, backward: bool) -> None:
    """Also where it begins, and ends, right beside a fold."""
    values, stable = [3.0, 4.0, 5.0, 4.0, 3.0, 2.0, 1.0, 2.0], [True, True, True, False, False, False, True, True]
    order = np.roll(np.arange(8)[:: -1 if backward else 1], begin)
    if order[0] in (2, 6):
        return  # it begins at a regular point
    order = np.append(order, order[0])
    kinds = {k: "fold" for k, i in enumerate(order.tolist()) if i in (2, 6)}
    one = branch_of([values[i] for i in order], [stable[i] for i in order], kinds, closed=True)
    (range_,) = following().stable_ranges([one])
    assert (range_.ends, range_.kinds) == ((1.0, 5.0), ("fold", "fold"))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_equations_along_the_parameter(sense: float) -> None:
    """J p'' = k (W - w - p') - T sin(p), scaled: by the motor's speed k, by the phase -T cos(p)."""
    case = case_of(5.0)
    equations = existence(case, not_entrained(case), {"rotor": sense}, Work()).equations
    assert equations is not None
    inertia, state = machine(5.0).values["rotor.inertia"], np.array([0.5, 6.0])
    phase, speed = (int(np.flatnonzero(equations.phases)[0]), int(np.flatnonzero(~equations.phases)[0]))
    state = state if phase == 0 else state[::-1]
    rate, jacobian, by_value = equations._linearisation(state[:, None], np.array([sense * 7.0]))
    scale = equations.pace * equations.sizes
    assert equations.pace == pytest.approx(W) and equations.sizes[phase] == 1.0 and equations.sizes[speed] == pytest.approx(W)
    torque = SLOPE * (7.0 - 6.0) - TORQUE * math.sin(0.5)
    assert rate[phase, 0] * scale[phase] == pytest.approx(6.0 - W)
    assert rate[speed, 0] * scale[speed] == pytest.approx(torque / inertia)
    assert jacobian[0, speed, phase] * scale[speed] == pytest.approx(-TORQUE * math.cos(0.5) / inertia)
    assert jacobian[0, speed, speed] == pytest.approx(-SLOPE / inertia / equations.pace)
    assert by_value[0, speed] * scale[speed] / equations.unit == pytest.approx(sense * SLOPE / inertia)
    roots = np.roots([inertia, SLOPE, TORQUE * math.cos(0.5)])
    assert sorted(equations.eigenvalues(state, 7.0).real) == pytest.approx(sorted(roots.real))
    assert equations.is_turning(state) and not equations.is_turning(np.where(equations.phases, 0.5, -6.0))


def test_all_rotors_must_turn_in_their_senses() -> None:
    made: Any = SimpleNamespace(phases=np.array([True, False, False]))
    turning = existence_module.EntrainmentEquations.is_turning
    assert turning(made, np.array([-1.0, 2.0, 3.0])) and not turning(made, np.array([1.0, 2.0, -3.0]))


def test_starts_lie_around_the_circle_at_speeds_up_to_that_of_the_fastest_motor(monkeypatch: pytest.MonkeyPatch) -> None:
    from wucht.dynamics.entrainment import entrainment_equations as module

    rotors = ["a", "b", "c"]
    of: Any = SimpleNamespace(
        phases=np.array([True, False]), n=2, pace=7.0, machine=SimpleNamespace(shaken_coordinate=None, rotors=rotors)
    )
    monkeypatch.setattr(module, "free_speed", lambda _, rotor: {"a": 9.0, "b": -12.0, "c": None}[rotor])
    phases, speeds = module.EntrainmentEquations.starts(of)
    assert np.unique(np.round(speeds, 9)) == pytest.approx(sorted([*np.linspace(3.6, 13.2, 9), 10.5]))
    assert np.diff(np.unique(phases)) == pytest.approx([2 * math.pi / 12] * 11) and len(phases) == 12 * 10
    of.machine.shaken_coordinate = object()
    assert module.EntrainmentEquations.starts(of)[1].tolist() == [7.0] * 12


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_state_of_an_entrained_run_has_a_speed_without_sign(monkeypatch: pytest.MonkeyPatch, sense: float) -> None:
    case, given = case_of(sense * 5.0), list[tuple[float, float]]()
    of = existence_module.EntrainmentEquations
    original = of.state_at

    def state_at(self: Any, machine: Machine, time: float, state: np.ndarray, speed: float) -> np.ndarray:
        given.append((time, speed))
        return original(self, machine, time, state, speed)

    monkeypatch.setattr(of, "state_at", state_at)
    run = RunFromStart(5.0, 1.0, 3.0, case.initial, is_entrained=True, mean_speed=sense * W)
    existence(case, run, {"rotor": sense}, Work())
    assert given == [(3.0, W)]
