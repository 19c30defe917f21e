"""The study ``synchronous-states``: closed forms against the complete search, families, maps, refusals, the command."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.refusals import check_refusal, refused

from wucht import Machine, SynchronousStates, integrate, load_machine, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.configurations.averaged_stability import REGIONS, AveragedStability, averaged_matrices
from wucht.analysis.configurations.closed_form import State, family_members, fixed_speed_states
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.search import index, search_by_subdivision, search_from_many_starts, speeds_in_line
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.files.building import machine_from
from wucht.machines.operation import machine_at_speed, natural_frequencies
from wucht.machines.structure import SPEED
from wucht.numerics.flow.jacobian import Jacobian
from wucht.piecewise import PiecewiseCubic, step

Entry = dict[str, Any]

ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
CARRIER = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": [40.0, 60.0]}
HELD = {"kind": "constant-speed", "speed": 100.0}
MOTOR = {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}


def balls(*unbalances: float, **more: Any) -> list[dict[str, Any]]:
    """Pendulums 0.5 m long with these unbalances (kg m)."""
    common = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    return [common | {"name": f"b{k}", "mass": u / 0.5} | more for k, u in enumerate(unbalances)]


def machine(*unbalances: float, drive: Any = HELD, carrier: Any = None, rotor: Any = None, **more: Any) -> Machine:
    described: dict[str, Any] = {
        "carrier": CARRIER | (carrier or {}),
        "bodies": [ROTOR | (rotor or {}), *balls(*unbalances, **more)],
    }
    return machine_from(described | ({"drive": drive} if drive else {}))


def exciters(count: int, held: float | None = None, slope: float = 0.1) -> Machine:
    """Rotors that only a planar body connects."""
    places = [[0.3, 0.0], [-0.3, 0.1], [0.0, 0.4], [0.1, -0.4], [-0.2, -0.3]][:count]
    carrier = {
        "directions": "xyr", "mass": 50.0, "inertia": 6.0, "stiffness": 1e5, "damping": 400.0, "rotation_stiffness": 1e4,
        "rotation_damping": 40.0,
    }  # fmt: skip
    bodies = [ROTOR | {"name": f"e{k}", "position": at, "unbalance": 1e-2 * (1 + 0.1 * k)} for k, at in enumerate(places)]
    drives = [
        {"on": f"e{k}", "kind": "linear", "slope": slope, "no_load_speed": 100.0 + 0.02 * k * (-1) ** k} for k in range(count)
    ]
    if held is not None:
        drives[0] = {"on": "e0", "kind": "constant-speed", "speed": held}
    return machine_from({"carrier": carrier, "bodies": bodies, "drives": drives})


def answer(m: Machine, **question: Any) -> dict[str, Any]:
    summary: dict[str, Any] = json.loads(run(SynchronousStates(**question), m).attrs["summary"])
    return summary


def same(states: list[State], others: list[State]) -> bool:
    """Whether both hold the same states, in any order."""

    def apart(a: State, b: State) -> float:
        turned = np.abs((a.phases - b.phases + np.pi) % (2 * np.pi) - np.pi)
        return max(float(turned.max()), abs(a.speed - b.speed) / a.speed)

    return len(states) == len(others) and all(min(apart(a, b) for b in others) < 1e-8 for a in states)


# --- closed forms against the search ---


def test_equal_bodies_are_counted_once() -> None:
    torques = SteadyTorques.of(machine(0.008, 0.008))
    closed, searched = fixed_speed_states(torques, 100.0), search_by_subdivision(torques, 0.0, 0.0)
    assert [s.multiplicity for s in closed] == [2, 2, 1, 1]
    assert sorted(s.multiplicity for s in searched.states) == [1, 1, 2, 2]
    assert len(closed) == len(searched.states) == 4


def test_three_bodies_without_a_polygon_are_found_completely() -> None:
    """f_0 is longer than all others together: nothing compensates, and 2^3 states are in line."""
    torques = SteadyTorques.of(machine(0.002, 0.003, 0.0035))
    closed, searched = fixed_speed_states(torques, 100.0), search_by_subdivision(torques, 0.0, 0.0)
    assert len(closed) == 8
    assert searched.complete
    assert same(closed, searched.states)


def test_a_family_is_what_the_search_leaves_undecided() -> None:
    """Three bodies that compensate: the boxes along S = 0 stay undecided, and all isolated states are found."""
    torques = SteadyTorques.of(machine(0.006, 0.007, 0.008))
    closed, searched = fixed_speed_states(torques, 100.0), search_by_subdivision(torques, 0.0, 0.0, 60_000)
    assert [s.dimension for s in closed] == [1, *[0] * 8]
    assert not searched.complete
    assert "remain undecided" in searched.evidence
    assert same(closed[1:], searched.states)


@pytest.mark.parametrize(
    ("count", "held", "number"),
    [(2, 99.9, 2), *(pytest.param(*given, marks=pytest.mark.slow) for given in ((3, None, 4), (4, None, 10), (4, 99.9, 8)))],
)
def test_exciters_are_found_completely(count: int, held: float | None, number: int) -> None:
    m = exciters(count, held)
    summary = answer(m, full=False)
    assert summary["complete"], summary["shown"]
    torques = SteadyTorques.of(m)
    states = search_from_many_starts(torques, 0.1, 100.01, [])
    assert len(states) == len(summary["states"]) == number
    for state in states:
        left = torques.residual(np.array([state.speed]), state.phases[:, None])[list(torques.free), 0]
        assert np.abs(left).max() < 1e-10


@pytest.mark.parametrize("bodies", ["balls", pytest.param("rotors", marks=pytest.mark.slow)])
def test_indices_add_up_to_zero(bodies: str) -> None:
    """Poincare and Hopf: the torque balance is a vector field on a torus. Without one of its zeros they do not."""
    torques = SteadyTorques.of(machine(0.002, 0.003, 0.0035) if bodies == "balls" else exciters(3, 99.9))
    states = search_from_many_starts(torques, 0.0, 0.0, [])
    assert index(torques, states) == 0
    assert index(torques, states[1:]) != 0


def test_speeds_in_line_are_found_completely() -> None:
    """Two unequal balls and a motor that the resonance may hold: the same speeds as in closed form over the speed."""
    m = machine(0.012, 0.008, drive=MOTOR)
    summary = answer(m, full=False)
    assert summary["complete"]
    in_line = speeds_in_line(SteadyTorques.of(m), 0.11, 110.02)
    assert in_line is not None
    speeds = sorted(s["speed"] for s in summary["states"] if s["name"] != "compensating")
    assert speeds == pytest.approx(in_line, rel=1e-9)
    assert len(speeds) >= 4
    assert [s["speed"] for s in summary["states"] if s["name"] == "compensating"] == pytest.approx([110.0] * 2)


TABLE = {"kind": "table", "points": [[0, 50], [60, 30], [110, 0], [120, -5]]}
STEEP = {"kind": "linear", "slope": 0.4, "no_load_speed": 110.0}
CHARACTERISTICS = {
    "table": (TABLE, None),
    "fan": (STEEP, {"kind": "quadratic", "coefficient": 1e-4}),
    "brake": (STEEP, {"kind": "coulomb", "torque": 2.0}),
}


# A measured load has the breakpoints of a measured drive.
@pytest.mark.parametrize("case", ["table", "fan", pytest.param("brake", marks=pytest.mark.slow)])
def test_characteristics_with_breakpoints_are_shown_complete(case: str) -> None:
    """Kinks of tables, the square with its sign, a smoothed step: bounds on their slopes hold on both sides."""
    drive, load = CHARACTERISTICS[case]
    described: dict[str, Any] = {"carrier": CARRIER, "bodies": [ROTOR, *balls(0.004)], "drive": drive}
    m = machine_from(described | ({"load": load} if load else {}))
    summary = answer(m, full=False)
    assert summary["complete"], summary["shown"]
    # Independently: at each speed the ball has two phases; their rotor's torque changes its sign where a state is.
    torques, grid = SteadyTorques.of(m), np.linspace(0.12, 119.9, 2000)
    fixed = torques.with_fixed_speed(100.0)
    held = [fixed_speed_states(fixed, w) for w in grid]
    phases = np.array([[s.phases for s in states] for states in held])  # (N, 2, 2)
    left = np.array([torques.residual(grid, phases[:, k].T)[0] for k in (0, 1)])
    crossings = [np.flatnonzero(np.diff(np.sign(row))) for row in left]
    expected = sorted(float(np.interp(0.0, *zip(*sorted(zip(row[i : i + 2], grid[i : i + 2], strict=True)), strict=True)))
                      for row, at in zip(left, crossings, strict=True) for i in at)  # fmt: skip
    assert sorted(s["speed"] for s in summary["states"]) == pytest.approx(expected, abs=1e-3)
    assert len(expected) >= 2


def test_a_characteristic_that_jumps_is_not_shown_complete() -> None:
    torques = SteadyTorques.of(machine(0.004, drive=MOTOR))
    jumps = replace(
        torques, shaft_torques=(PiecewiseCubic(SPEED, step("torque", 60.0, 50.0, 5.0)) - SPEED / 20, torques.shaft_torques[1])
    )
    searched = search_by_subdivision(jumps, 1.0, 120.0)
    assert not searched.complete
    assert searched.evidence.startswith("a drive or load has a characteristic that jumps")


# --- the description of a state ---


def test_what_is_left_of_the_unbalance() -> None:
    summary = answer(machine(0.004, 0.003), full=False)
    for state in summary["states"]:
        b0, b1 = state["phases"].values()
        left = abs(1e-2 + 0.004 * np.exp(1j * b0) + 0.003 * np.exp(1j * b1))
        assert state["residual_unbalance"] == pytest.approx(left, rel=1e-12)
        assert state["residual_share"] == pytest.approx(left / 1e-2, rel=1e-12)
    assert {s["name"] for s in summary["states"]} == {"together", "opposed"}
    assert all(s["type"] is None for s in summary["states"])  # the types of 002 are those of equal pendulums


def test_a_single_body() -> None:
    """It compensates only a rotor of the same unbalance."""
    assert {s["name"] for s in answer(machine(0.004), full=False)["states"]} == {"together", "opposed"}
    names = {s["name"]: s for s in answer(machine(0.01), full=False)["states"]}
    assert set(names) == {"together", "compensating"}
    assert names["compensating"]["phases"]["b0"] == pytest.approx(math.pi)
    assert names["compensating"]["amplitude"] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("count", [3, pytest.param(6, marks=pytest.mark.slow)])
def test_a_family_has_one_entry(count: int) -> None:
    m = machine(*[0.006] * count)
    summary = answer(m)
    family = summary["states"][0]
    assert (family["name"], family["family_dimension"]) == ("compensating", count - 2)
    turned = sum(0.006 * np.exp(1j * p) for p in family["phases"].values())
    assert abs(1e-2 + turned) < 1e-12
    assert family["stable_slow"] is family["stable_full"] is True
    assert family["family_stable_share"] == 1.0
    assert len(summary["states"]) == 1 + count + 1
    assert sum(s["multiplicity"] for s in summary["states"][1:]) == 2**count


def test_the_members_of_a_family_are_all_judged_without_inertia_too() -> None:
    """Three balls just above resonance of an anisotropic carrier: each member's exponents against difference quotients."""
    m = machine(0.006, 0.006, 0.006, carrier={"damping": [300.0, 300.0]})
    torques, averaged_equations = SteadyTorques.of(m), averaged_equations_of(m, inertia=False)
    state = next(s for s in fixed_speed_states(torques, 100.0) if s.dimension)
    at = family_members(torques, 5)
    of_members = AveragedStability(torques, averaged_equations).exponents(state, at)
    linear, h = Jacobian.of(averaged_equations.system), 1e-6
    for k, phases in enumerate(at.T):
        x = averaged_equations.steady_state(state.speed, phases)
        ahead, behind = (
            np.array([linear.values_at(x + s * h * e, averaged_equations.values())[0] for e in np.eye(len(x))]).T
            for s in (1, -1)
        )
        exponents = np.linalg.eigvals((ahead - behind) / (2 * h))
        rest = np.sort(exponents[np.argsort(np.abs(exponents))][state.dimension :].real)
        assert np.sort(of_members[k].real) == pytest.approx(rest, rel=1e-5)
    assert np.ptp(of_members.imag, axis=0).max() > 1.0, "the members differ"


def test_a_balanced_rotor() -> None:
    """Two equal balls compensate each other anywhere: a family of one parameter; unequal ones are dragged."""
    summary = answer(machine(0.006, 0.006, rotor={"unbalance": 0.0}), full=False)
    (family,) = summary["states"]
    assert (family["name"], family["family_dimension"], family["residual_share"]) == ("compensating", 1, None)
    first, second = family["phases"].values()
    assert abs(first - second) == pytest.approx(math.pi)
    assert answer(machine(0.006, 0.005, rotor={"unbalance": 0.0}), full=False)["states"] == []


@pytest.mark.slow
def test_bodies_of_a_track_that_overlap_are_marked() -> None:
    summary = answer(load_machine("practice/grinder-4-balls"), full=False)
    family, *others = summary["states"]
    assert family["family_dimension"] == 2
    assert not family["overlapping"]
    assert all(s["overlapping"] for s in others)


def test_released_bodies() -> None:
    result = run(SynchronousStates(), load_machine("sperling-vibration/figure-4"))
    assert "b1 is assumed to be released" in result.attrs["warnings"]
    state = result.wucht.summary["states"][0]
    assert [round(math.degrees(p), 2) for p in state["phases"].values()] == [128.68, 231.32]
    assert state["stable_full"]


@pytest.mark.slow
def test_clockwise_is_the_mirror_image() -> None:
    forward = answer(machine(0.012, 0.008))
    backward = answer(machine(0.012, 0.008, drive=HELD | {"speed": -100.0}))
    assert backward["speed"] == -100.0
    assert len(forward["states"]) == len(backward["states"]) == 6
    for state in forward["states"]:
        mirrored = {name: (-p) % (2 * math.pi) for name, p in state["phases"].items()}
        twin = min(
            backward["states"],
            key=lambda s: sum(1 - math.cos(s["phases"][n] - p) for n, p in mirrored.items()),
        )
        assert np.cos(np.subtract(list(twin["phases"].values()), list(mirrored.values()))) == pytest.approx([1, 1], abs=1e-12)
        assert (twin["stable_slow"], twin["stable_full"]) == (state["stable_slow"], state["stable_full"])
        assert twin["growth_full"] == pytest.approx(state["growth_full"], rel=1e-5)


def test_a_range_of_speeds() -> None:
    m = machine(0.012, 0.008, drive=MOTOR)
    whole, part = answer(m, full=False), answer(m, full=False, range=(109.5, 111.0))
    inside = [s["speed"] for s in whole["states"] if 109.5 <= s["speed"] <= 111.0]
    assert 0 < len(inside) < len(whole["states"])
    assert [s["speed"] for s in part["states"]] == pytest.approx(inside, rel=1e-9)


@pytest.mark.slow
def test_self_synchronising_exciters() -> None:
    """001 section 2.3: in phase below, in opposition above the natural frequency; there both may be captured at resonance."""
    stiff = answer(load_machine("sperling-vibration/self-synchronisation-stiff"))
    soft = answer(load_machine("sperling-vibration/self-synchronisation-soft"))
    assert stiff["complete"]
    assert soft["complete"]
    fast = [{s["name"]: s["stable_full"] for s in summary["states"] if s["speed"] > 11} for summary in (stiff, soft)]
    assert fast == [{"together": True, "opposed": False}, {"together": False, "opposed": True}]
    slow = [s for s in soft["states"] if s["speed"] < 11]
    assert [(s["name"], round(s["speed"], 3)) for s in slow if s["stable_full"]] == [("together", 6.006)]
    apart = [s for s in slow if s["name"] is None]  # both at the natural frequency, neither together nor opposed
    assert [s["speed"] for s in apart] == pytest.approx([2 * math.pi] * 2, rel=1e-9)


# --- stability ---


@pytest.mark.slow
@pytest.mark.parametrize("given", [None, 100.0])
def test_the_slow_matrix_is_that_of_the_slow_equations(given: float | None) -> None:
    for m in (machine(0.006, 0.007, 0.008, drive=MOTOR), exciters(3)):
        averaged_equations = averaged_equations_of(m, has_fixed_speed=given is not None)
        torques = SteadyTorques.from_averaged_equations(averaged_equations_of(m))
        torques = torques if given is None else torques.with_fixed_speed(given)
        state = State(given or 97.0, np.array([0.0, 1.0, 2.5, 4.0][: torques.size]))
        matrix = averaged_matrices(torques, np.array([state.speed]), state.phases[:, None])[0]
        jacobian = Jacobian.of(averaged_equations.system).values_at(
            averaged_equations.steady_state(state.speed, state.phases), averaged_equations.values(given)
        )[1]
        assert np.sort_complex(np.linalg.eigvals(matrix)) == pytest.approx(
            np.sort_complex(np.linalg.eigvals(jacobian)), rel=1e-9
        )


def test_without_inertia_the_slowest_exponents_stay() -> None:
    """Strong damping: the reduction, 002 (4.60)-(4.62), has the same slow exponents within the ratio of both rates."""
    m = machine(0.012, 0.008, damping=0.2)
    with_, without = answer(m, full=False), answer(m, full=False, inertia=False)
    for first, second in zip(with_["states"], without["states"], strict=True):
        assert first["stable_slow"] is second["stable_slow"]
    assert without["states"][0]["growth_slow"] == pytest.approx(with_["states"][0]["growth_slow"], rel=0.1)


def test_an_exponent_that_is_zero_is_not_decided() -> None:
    """Without dampers to the rotor the balls librate for ever in the averaged equations."""
    torques = SteadyTorques.of(machine(0.012, 0.008, carrier={"damping": [0.0, 0.0]}))
    free = replace(torques, relative=np.zeros((3, 3)))
    averaged_equations = averaged_equations_of(machine(0.012, 0.008, carrier={"damping": [0.0, 0.0]}))
    stability = AveragedStability(free, averaged_equations).stability(fixed_speed_states(free, 200.0)[0])
    assert stability.stable is None
    assert stability.reason == "neither grows nor decays"


def test_multipliers_can_be_left_out() -> None:
    summary = answer(machine(0.012, 0.008), full=False)
    assert {s["stable_full"] for s in summary["states"]} == {None} and summary["full"] is False
    assert {s["why"] for s in summary["states"]} == {"the multipliers were not requested"}
    assert "stable in the averaged equations (the full ones were not evaluated): compensating" in summary["sentence"]


def test_what_the_full_equations_do_not_decide_is_not_called_stable() -> None:
    """A full run leaves the state at 6.16 rad/s; the averaged equations call it stable, no periodic motion is near it."""
    summary = answer(load_machine("sperling-vibration/self-synchronisation-lost"))
    verdicts = Counter(s["verdict"] for s in summary["states"])
    assert verdicts == {
        "stable": 1, "stable in the averaged equations only": 1, "unstable in the averaged equations only": 1, "unstable": 3,
    }  # fmt: skip
    undecided = next(s for s in summary["states"] if s["verdict"] == "stable in the averaged equations only")
    assert undecided["speed"] == pytest.approx(6.16, abs=0.01)
    assert undecided["stable_full"] is None and summary["complete"]
    assert "stable in the averaged equations only, undecided in the full ones" in summary["sentence"]


def test_what_neither_equations_decide_is_undecided() -> None:
    """At a twentieth of a radian a second the vibration is too small to tell anything."""
    summary = answer(machine(0.012, 0.008, drive=HELD | {"speed": 0.05}), full=False)
    assert {s["verdict"] for s in summary["states"]} == {"undecided"}
    assert "none of them proved stable in the averaged equations; undecided: compensating (2)" in summary["sentence"]


@pytest.mark.slow
def test_a_family_that_gravity_breaks_is_judged_across_it() -> None:
    """The washing machine: its balls creep along the family; across it everything decays, the drum's speed slowest."""
    family = answer(load_machine("practice/laundry-drum"))["states"][0]
    assert (family["name"], family["family_dimension"], family["verdict"]) == ("compensating", 4, "stable")
    assert family["growth_full"] == pytest.approx(math.log(0.99456) * 126.165 / (2 * math.pi), rel=1e-3)
    assert "broken by gravity: bodies creep along it" in family["why"]


@pytest.mark.slow
def test_a_family_that_gravity_breaks_against_a_long_run() -> None:
    """Over two hundred turns the phases creep as far as one turn says two hundred times."""
    m = machine_at_speed(machine(0.006, 0.006, 0.006, 0.006, carrier={"gravity": 9.81, "damping": [300.0, 400.0]}), None)
    torques = SteadyTorques.of(m)
    state = next(s for s in fixed_speed_states(torques, 100.0) if s.dimension)
    full, turns = FullStability(torques, True), 200
    orbit = full.orbit(state)
    names = full.flow.system.state_names
    angles = [names.index(b.coordinate.position.name) for b in m.bodies]
    time = orbit.period * np.array([0, 200, 200 + turns])
    run = integrate(full.flow, orbit.state, np.array(full.flow.system.values(m.values)), time)
    moved = run.states[angles, 2] - run.states[angles, 1] - 2 * math.pi * turns
    drift = turns * orbit.creep(1 + state.dimension)[angles]
    assert np.abs(drift).max() > 1e-4
    assert moved == pytest.approx(drift, rel=0.1, abs=0.02 * np.abs(drift).max())


# --- speeds ---


@pytest.mark.slow
def test_a_torque_that_ends_leaves_the_speed_that_is_reached() -> None:
    """From 200 rad/s on the table has none: the state is there, not at the end of the search, and a run reaches it."""
    table = {"kind": "table", "points": [[0, 20], [100, 15], [150, 10], [200, 0]]}
    summary = answer(machine(0.012, 0.008, drive=table))
    first, second = (s for s in summary["states"] if s["name"] == "compensating")
    for state in (first, second):
        assert state["speed"] == 200.0
        assert (state["verdict"], state["indifferent"]) == ("stable", True)
        assert state["why"].startswith("no torque acts from this speed on: all greater speeds are steady too")
    assert not any(s["indifferent"] for s in summary["states"] if s["name"] != "compensating")
    beyond = machine(0.012, 0.008, drive=table | {"points": [*table["points"], [250, 0], [260, -5]]})
    # Interpolated smoothly it comes to zero with the square of the distance, to rounding a little earlier.
    speeds = [s["speed"] for s in answer(beyond, full=False)["states"] if s["name"] == "compensating"]
    assert speeds == pytest.approx([200.0, 200.0], rel=1e-8)


def undamped() -> Machine:
    bodies = [
        {"kind": "rotor", "name": f"e{k}", "mass": 5, "unbalance": u, "inertia": 0.02, "bearing_damping": 0.002}
        for k, u in enumerate((0.05, 0.04))
    ]
    drives = [{"on": f"e{k}", "kind": "linear", "slope": 0.2, "no_load_speed": 100 + k} for k in (0, 1)]
    return machine_from(
        {"carrier": {"directions": "x", "stiffness": 5e4, "damping": 0, "mass": 80}, "bodies": bodies, "drives": drives}
    )


def test_no_state_lies_at_an_undamped_resonance() -> None:
    """Without damping the vibration takes nothing from all together: the drives alone give the speed, 40.2/0.404."""
    summary = answer(undamped(), full=False)
    assert [s["speed"] for s in summary["states"]] == pytest.approx([40.2 / 0.404] * 2, rel=1e-12)
    assert summary["complete"]
    assert "(except 23.57, where the undamped vibration is infinite)" in summary["shown"]
    torques = SteadyTorques.of(undamped())
    (pole,) = torques.poles(0.1, 101.0)
    assert pole == pytest.approx(math.sqrt(5e4 / 90))
    assert not torques.is_balanced(pole, np.array([0.0, math.pi]))
    assert (
        "subdivision, 22 boxes" in search_by_subdivision(torques, 0.101, 101.0101).evidence
    )  # not a hundred thousand at the pole


def test_all_torques_together_are_what_the_carrier_dissipates() -> None:
    """The first equation of the search is the sum of the others, to rounding, also where bodies in line stand for several."""
    draw = np.random.default_rng(3)
    for m in (exciters(4), machine(0.012, 0.008, drive=MOTOR)):
        torques = SteadyTorques.of(m)
        w, phases = draw.uniform(20, 120, 30), draw.uniform(0, 6, (torques.size, 30))
        left = torques.residual(w, phases)
        assert torques.total(w, phases) == pytest.approx(left.sum(axis=0), abs=1e-9 * np.abs(left).max())


# --- the map ---


@pytest.mark.slow
def test_the_map_is_that_of_the_states() -> None:
    """A cell says what the study says at its speed and with its rotor."""
    axes = {"speed": (20.0, 130.0, 11), "ratio": (0.2, 3.2, 5)}
    m = machine(0.012, 0.008)
    result = run(SynchronousStates(axes=axes, full=False), m)
    assert list(result.region.values) == list(REGIONS)
    assert result.map_speed.values[[0, -1]] == pytest.approx([25.0, 125.0])
    assert result.map_ratio.values == pytest.approx([0.5, 1.1, 1.7, 2.3, 2.9])
    seen = set()
    for i, ratio in enumerate(result.map_ratio.values):
        for k, speed in enumerate(result.map_speed.values):
            rotor = {"unbalance": 0.02 / float(ratio)}
            cell = answer(machine(0.012, 0.008, rotor=rotor), speed=float(speed), full=False)["states"]
            stable = {_region(s) for s in cell if s["stable_slow"]}
            assert {REGIONS[r] for r in np.flatnonzero(result.map_stable.values[:, i, k])} == stable, (ratio, speed)
            assert {REGIONS[r] for r in np.flatnonzero(result.map_exists.values[:, i, k])} == {_region(s) for s in cell}
            seen |= stable
    assert seen >= {"compensating", "together, adding", "together, reducing"}


def _region(state: Entry) -> str:
    if state["name"] != "together":
        return str(state["name"])
    return "together, adding" if state["residual_share"] >= 1 else "together, reducing"


def test_the_map_of_a_family() -> None:
    axes = {"speed": (20.0, 130.0, 8), "ratio": (0.0, 3.0, 6)}
    result = run(SynchronousStates(axes=axes, full=False), machine(0.004, 0.004, 0.004))
    stable = result.map_stable.sel(region="compensating").values.astype(bool)
    assert stable[result.map_ratio.values > 1][:, -1].all()
    assert not stable[result.map_ratio.values < 1].any()
    assert not result.map_exists.sel(region="compensating").values[result.map_ratio.values < 1].any()
    assert not stable[:, 0].any()


# --- refusals ---


def test_refused_machines() -> None:
    moved = {"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}}
    with refused("machine.bodies", "study.kind", "torque-balance", code="single-body"):
        run(SynchronousStates(), machine(drive=MOTOR))
    with refused("machine.bodies", "study.kind", "response", code="single-body"):
        run(SynchronousStates(), machine())
    with refused("machine.bodies", "disc", "s1", "study.kind", "run-up", code="slider"):
        run(SynchronousStates(), load_machine("sperling-vibration/figure-7"))
    with refused("machine.carrier.motion", "study.kind", "entrainment", code="single-body"):
        run(SynchronousStates(), load_machine("sperling-vibration/sustained-rotation"))
    with refused("machine.carrier.motion", "study.kind", "entrainment", code="prescribed"):
        run(SynchronousStates(), machine_from({"carrier": moved, "bodies": [ROTOR, *balls(0.01)], "drive": MOTOR}))
    with refused("study.speed", code="missing"):
        run(SynchronousStates(), machine(0.01, drive=None))
    with refused("study.speed", code="missing"):
        run(SynchronousStates(), machine(0.012, 0.008, drive={"kind": "linear", "slope": 0.0, "no_load_speed": 110.0}))
    with refused("machine.drive", code="stands-still"):
        run(SynchronousStates(), machine(0.01, drive=HELD | {"speed": 0.0}))
    with refused("machine.bodies", "11", given=12):
        run(SynchronousStates(), machine(*[0.001] * 11))
    still = {"carrier": {"directions": "fixed"}, "bodies": [ROTOR, *balls(0.01)], "drive": HELD}
    with refused("machine", code="still"):
        run(SynchronousStates(), machine_from(still))
    light = [ROTOR | {"unbalance": 1e-12}, *balls(0.012, 0.008)]
    light[1] |= {"mass": 1e-20}
    with refused("machine", code="no-unbalance"):
        run(SynchronousStates(), machine_from({"carrier": CARRIER, "bodies": light, "drive": HELD}))
    ends = {"kind": "table", "points": [[0, 20], [100, 0]]}
    with refused("study.speed", code="not-driven"):
        run(SynchronousStates(range=(150.0, 200.0)), machine(0.012, 0.008, drive=ends))
    with refused("study.inertia", given=False):
        run(SynchronousStates(inertia=False), machine(0.012, 0.008, damping=0.0))


@pytest.mark.parametrize(
    "table",
    [
        {"speed": 0.0}, {"speed": "3 kg"}, {"range": [5, 10]}, {"range": [10, 5]}, {"inertia": 1}, {"full": "no"},
        {"axes": 3}, {"axes": {"speed": [1, 2, 3]}}, {"axes": {"speed": [1, 2, 3], "ratio": [0, 2]}},
        {"axes": {"speed": [1, 2, 3], "ratio": [0, 2, 2.5]}}, {"axes": {"speed": [1, 2, 5000], "ratio": [0, 2, 3]}},
        {"axes": {"speed": [-1, 2, 3], "ratio": [0, 2, 3]}}, {"axes": {"sped": [1, 2, 3]}}, {"spede": 3}, {"speed": 1e29},
        {"speed": -1e-300}, {"axes": {"speed": [1, 1e29, 3], "ratio": [0, 2, 3]}},
        {"axes": {"speed": [1, 2, 3], "ratio": [0, 1e29, 3]}},
    ],
)  # fmt: skip
def test_refused_questions(table: dict[str, Any]) -> None:
    m = machine(0.012, 0.008)
    check_refusal(f"synchronous-states: {table}", lambda: run(SynchronousStates.from_table(table), m))


def test_a_map_of_bodies_with_torques_is_refused_beforehand() -> None:
    bodies = [ROTOR, *balls(0.012, 0.008)]
    loads = [{"on": "b0", "kind": "viscous", "coefficient": 0.01}]
    m = machine_from({"carrier": CARRIER, "bodies": bodies, "drive": HELD, "loads": loads})
    with refused("study.axes", code="own-torques"):
        run(SynchronousStates(axes={"speed": (1.0, 2.0, 3), "ratio": (0.0, 1.0, 3)}), m)


def test_the_natural_frequency_of_an_undamped_vibration_is_refused() -> None:
    bare = {"stiffness": 1e4, "damping": 0.0}
    m = machine(0.012, 0.008, carrier=bare)
    at = next(iter(natural_frequencies(m).values()))
    with refused("study.speed", code="resonance"):
        run(SynchronousStates(speed=at), m)
    with refused("machine.drive", code="resonance"):
        run(SynchronousStates(), machine(0.012, 0.008, carrier=bare, drive=HELD | {"speed": at}))
    run(SynchronousStates(speed=1.001 * at), m)


# --- the result and the command ---


def test_names_of_three_exciters_on_one_axis() -> None:
    """Together where all are; compensating where nothing is left."""
    bodies = [ROTOR | {"name": f"e{k}"} for k in range(3)]
    drives = [{"on": b["name"], "kind": "linear", "slope": 0.1, "no_load_speed": 100.0} for b in bodies]
    summary = answer(machine_from({"carrier": CARRIER, "bodies": bodies, "drives": drives}), full=False)
    by_left = {round(s["residual_share"], 6): s["name"] for s in summary["states"]}
    assert by_left[0.0] == "compensating"
    assert by_left[3.0] == "together"


@pytest.mark.parametrize(
    ("unbalances", "damping", "speed"),
    [
        ((0.012, 0.008), [0.0, 0.0], 30.0), ((0.02, 0.005), [40.0, 60.0], 100.0), ((0.003, 0.004), [400.0, 300.0], 58.0),
        ((0.012,), [0.0, 0.0], 30.0), ((0.003,), [40.0, 60.0], 100.0),
    ],
)  # fmt: skip
def test_one_or_two_bodies_are_found_completely(unbalances: tuple[float, ...], damping: list[float], speed: float) -> None:
    torques = SteadyTorques.of(machine(*unbalances, carrier={"damping": damping}, drive=HELD | {"speed": speed}))
    closed, searched = fixed_speed_states(torques, speed), search_by_subdivision(torques, 0.0, 0.0)
    assert searched.complete
    assert same(closed, searched.states)
    assert same(closed, search_from_many_starts(torques, 0.0, 0.0, []))
