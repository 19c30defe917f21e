"""The lines of ``synchronous-states``, what it says of families and of the end of the search, and its limits."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from test_synchronous_states import HELD, MOTOR, machine
from tests.refusals import refused

from wucht import SynchronousStates, load_machine, report, run

DC_SERIES = {
    "kind": "dc-series", "voltage": 100.0, "armature_resistance": 2, "field_resistance": 1, "field_inductance": 0.5,
    "motor_constant": 0.5,
}  # fmt: skip
AXES = {"speed": (20.0, 130.0, 3), "ratio": (0.2, 3.2, 4)}
K = math.sqrt(1e4 / 5.04), math.sqrt(2e4 / 5.04)


@cache
def pair(*unbalances: float, drive: str = "held") -> xr.Dataset:
    given = HELD if drive == "held" else MOTOR
    return run(SynchronousStates(full=False), machine(*unbalances, drive=given))


# --- lines ---


def test_equal_balls_have_types_and_several_ways() -> None:
    result = pair(0.01, 0.01)
    lines = report(result)[3:-2]
    assert {line[2:21].strip() for line in lines} == {"compensating (I)", "together (II)", "opposed (III)"}
    ways = [state["multiplicity"] for state in result.wucht.summary["states"]]
    assert [line.endswith(f", {count} ways") for line, count in zip(lines, ways, strict=True)] == [c > 1 for c in ways]
    assert max(ways) == 2


def test_what_a_state_throws_where_that_is_much_and_it_is_not_unstable() -> None:
    result = run(SynchronousStates(full=False), load_machine("practice/screen"))
    (stable,) = (s for s in result.wucht.summary["states"] if not s["verdict"].startswith("unstable"))
    (throw,) = [line.strip() for line in report(result) if "stroke" in line]
    direction = f"{math.degrees(stable['throw_direction']):.1f}°, machine number {stable['machine_number']:.3g}"
    assert throw == f"stroke {1e3 * stable['stroke']:.4g} mm peak to peak at {direction}"
    (line,) = [line for line in report(pair(0.004)) if "stroke" in line]
    assert " mm peak to peak, machine number " in line, "its orbit is nearly a circle: no direction"


@pytest.mark.parametrize(("speed", "is_told"), [(8.0, False), (30.0, True)])
def test_a_gentle_vibration_is_not_told(speed: float, is_told: bool) -> None:
    result = run(SynchronousStates(full=False), machine(0.004, drive=HELD | {"speed": speed}))
    stable = [state for state in result.wucht.summary["states"] if not state["verdict"].startswith("unstable")]
    assert all((state["machine_number"] >= 0.05) is is_told for state in stable) and stable
    assert any("stroke" in line for line in report(result)) is is_told


def test_of_too_many_states_those_that_are_stable_are_named() -> None:
    result = run(SynchronousStates(full=False), machine(*(0.004 + 0.0005 * k for k in range(5))))
    states, lines = result.wucht.summary["states"], report(result)
    named = [line for line in lines if ": b0 " in line]
    assert len(states) > 24 and len(named) == 24
    assert f"  and {len(states) - 24} more: see the Dataset" in lines
    count = sum(not state["verdict"].startswith("unstable") for state in states)
    assert sum("unstable" not in line for line in named) == count > 0


def test_without_verdict_of_the_full_equations_it_says_why() -> None:
    """Where averaged and full equations do not agree, both are named."""
    lines = report(run(SynchronousStates(), load_machine("sperling-vibration/self-synchronisation-lost")))
    undecided = "stable in the averaged, undecided in the full equations at "
    (k,) = [k for k, line in enumerate(lines) if undecided in line and "un" not in line[:26]]
    assert lines[k + 1].startswith("               ") and "stroke" not in lines[k + 1]


# --- the search, families, the map ---


def test_a_drive_that_runs_away_leaves_the_end_of_the_range_to_the_program() -> None:
    m = machine(0.012, 0.008, drive=DC_SERIES)
    end = "upper end is the program's choice, as the drive runs away without load: study.range sets another"
    s = run(SynchronousStates(full=False), m).wucht.summary
    assert not s["complete"] and s["shown"].endswith(f"; these are all in this range, but its {end}")
    assert f"  complete     not proved: {s['shown']}" in report(run(SynchronousStates(full=False), m))
    assert end not in run(SynchronousStates(full=False, range=(50.0, 150.0)), m).wucht.summary["shown"]


@pytest.mark.parametrize(
    ("speed", "slow", "full", "why"),
    [
        (54.2, None, True, "stable on 62 % of the family"),
        (55.0, False, True, "in the full equations all perturbations decay"),
        (55.6, False, None, "stable at 6 of 8 examined members of the family, not stable at this one"),
        (60.0, False, False, None),
    ],
)
def test_a_family_is_judged_by_its_members(speed: float, slow: bool | None, full: bool | None, why: str | None) -> None:
    """Three equal balls: near the border of stability some arrangements that hold the unbalance are stable, others are not."""
    result = run(SynchronousStates(), machine(0.006, 0.006, 0.006, drive=HELD | {"speed": speed}))
    family, lines = result.wucht.summary["states"][0], report(result)
    assert (family["family_dimension"], family["stable_slow"], family["stable_full"]) == (1, slow, full)
    assert family["growth_full"] is not None and (family["why"] or "").startswith(why or "")
    assert family["family_stable_share"] == {True: 1.0, False: 0.0}.get(slow, pytest.approx(0.62, abs=0.01))  # type: ignore[arg-type]
    words = {True: "stable", False: "unstable", None: "undecided"}
    same = f"{words[slow]}: " if slow is full else f"{words[slow]} in the averaged, {words[full]} in the full equations: "
    assert lines[3].startswith(f"  compensating       {same}b0 ")
    assert ", one of a family of dimension 1" in lines[3] and " ways" not in lines[3]
    assert (lines[4] == f"               {family['why']}") is (why is not None)
    warnings = [w for w in result.wucht.warnings if w.startswith("compensating at phases ")]
    assert bool(warnings) is ((slow, full) == (False, True))
    assert all(w.endswith(f" degrees: averaged and full equations disagree; {family['why']}") for w in warnings)


def test_shares_of_the_map() -> None:
    result = run(SynchronousStates(axes=AXES, full=False), machine(0.012, 0.008))
    shares = result.wucht.summary["map"]["stable_share"]
    stable = result.map_stable.values.astype(bool)
    assert shares == dict(zip(result.region.values.tolist(), stable.mean(axis=(1, 2)), strict=True)) | {
        "none": float((~stable.any(axis=0)).mean())
    }
    assert result.map_speed.values == pytest.approx(20 + 110 / 3 * np.array([0.5, 1.5, 2.5])), "centred"
    assert result.map_ratio.values == pytest.approx([0.575, 1.325, 2.075, 2.825])


# --- limits ---


def test_a_map_needs_balancing_bodies_an_unbalance_of_the_rotor_and_few_ways_to_be_in_line() -> None:
    asked = SynchronousStates(axes=AXES, full=False)
    with refused("study.axes", "no unbalance", given=None):
        run(asked, machine(0.006, 0.006, rotor={"unbalance": 0.0}))
    some = [0.001 + 0.0001 * k for k in range(7)]
    with refused("study.axes", "64", "128", given=None):
        run(asked, machine(*some))
    assert asked.prepare(machine(*some[:6]))[-1] is not None
    for without in (machine(0.01), load_machine("practice/screen")):
        with refused("study.axes", given=None, code="no-bodies"):
            run(asked, without)
    driven = machine(0.012, 0.008, drive=MOTOR | {"no_load_speed": 100.0})
    near, far = (SynchronousStates(axes=AXES | {"speed": (20.0, high, 3)}, full=False) for high in (0.999e5, 1.001e5))
    assert near.prepare(driven)[-1] is not None
    with refused("study.axes.speed", "1e+05 rad/s", given=[20.0, 1.001e5, 3]):
        run(far, driven)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_range_is_searched_in_the_sense_of_the_drive(sense: float) -> None:
    """Speeds from a thousandth of the lowest natural frequency to a thousand times that of the drive can be computed."""
    m = machine(0.012, 0.008, drive=MOTOR | {"no_load_speed": sense * 110.0})

    def searched(low: float, high: float) -> Any:
        return run(SynchronousStates(full=False, range=tuple(sorted((sense * low, sense * high)))), m).wucht.summary["range"]

    assert searched(100.0, 120.0) == [sense * 100.0, sense * 120.0]
    assert searched(0.0, 120.0) == pytest.approx([sense * 1e-3 * K[0], sense * 120.0], rel=1e-9)
    for code, low, high in (
        ("other-sense", -100.0, 120.0), ("other-sense", -120.0, -100.0), ("limits", 0.01, 0.99e-3 * K[0]),
        ("limits", 10.0, 1.01e3 * 110.0),
    ):  # fmt: skip
        with refused("study.range", given=sorted([sense * low, sense * high]), code=code):
            searched(low, high)


@pytest.mark.parametrize(
    ("sense", "speed", "is_allowed"),
    [(-1.0, 1.01e-3 * K[0], True), (1.0, 0.99e-3 * K[0], False), (-1.0, 1.01e3 * 110.0, False)],
)
def test_a_given_speed_is_one_that_can_be_computed_in_either_sense(sense: float, speed: float, is_allowed: bool) -> None:
    m = machine(0.012, 0.008, drive=MOTOR)
    asked = SynchronousStates(full=False, speed=sense * speed)
    if is_allowed:
        assert run(asked, m).wucht.summary["speed"] == pytest.approx(sense * speed)
        return
    with refused("study.speed", given=sense * speed):
        run(asked, m)


def test_the_lines_of_machines_whose_speed_is_given_or_not() -> None:
    lines = report(pair(0.012, 0.008))
    assert lines[2] == "  speed        100 rad/s (955 rpm), given"
    phases = pair(0.012, 0.008).wucht.summary["states"][0]["phases"].items()
    angles = ", ".join(f"{name} {math.degrees(phase):.2f}°" for name, phase in phases)
    assert lines[3] == f"  compensating       stable in the averaged equations: {angles}, 0 % of the unbalance remains"
    free = report(pair(0.012, 0.008, drive="motor"))
    assert free[2].startswith("  compensating       stable in the averaged equations at 110 rad/s (1050 rpm): b0 ")
