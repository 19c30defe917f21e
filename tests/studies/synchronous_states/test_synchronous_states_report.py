"""The lines of ``synchronous-states``, what it says of families and of the end of the search, and its limits."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

from wucht import Machine, SynchronousStates, load_machine, report, run
from wucht.files.building import machine_from

BALL = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
HELD = {"kind": "constant-speed", "speed": 100.0}
MOTOR = {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}
DC_SERIES = {
    "kind": "dc-series", "voltage": 100.0, "armature_resistance": 2, "field_resistance": 1, "field_inductance": 0.5,
    "motor_constant": 0.5,
}  # fmt: skip
AXES = {"speed": (20.0, 130.0, 3), "ratio": (0.2, 3.2, 4)}
K = math.sqrt(1e4 / 5.04), math.sqrt(2e4 / 5.04)


def machine(*unbalances: float, drive: dict[str, Any] = HELD, **rotor: Any) -> Machine:
    balls = [BALL | {"name": f"b{k}", "mass": u / 0.5} for k, u in enumerate(unbalances)]
    carrier = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": [40.0, 60.0]}
    return machine_from({"carrier": carrier, "bodies": [ROTOR | rotor, *balls], "drive": drive})


def states_of(m: Machine, **question: Any) -> list[dict[str, Any]]:
    states: list[dict[str, Any]] = run(SynchronousStates(**{"full": False} | question), m).wucht.summary["states"]
    return states


@cache
def pair(*unbalances: float, drive: str = "held") -> xr.Dataset:
    given = HELD if drive == "held" else MOTOR
    return run(SynchronousStates(full=False), machine(*unbalances, drive=given))


# --- lines ---


def angles(state: dict[str, Any]) -> str:
    return ", ".join(f"{name} {math.degrees(phase):.2f}°" for name, phase in state["phases"].items())


def test_the_lines_of_a_machine_whose_speed_is_given() -> None:
    result = pair(0.012, 0.008)
    s, lines = result.wucht.summary, report(result)
    first, last = s["states"][0], s["states"][-1]
    assert lines[2] == "  speed        100 rad/s (955 rpm), given"
    line = f"  compensating       stable in the averaged equations: {angles(first)}, 0 % of the unbalance remains"
    assert lines[3] == line, "the multipliers were not requested: no reason is given"
    share = f"{100 * last['residual_share']:.3g} % of the unbalance remains"
    assert lines[2 + len(s["states"])].startswith(f"  {last['name']:18} unstable in the averaged equations: b0 ")
    assert lines[2 + len(s["states"])].endswith(share) and "360.00°" not in "".join(lines)
    assert lines[-2] == f"  complete     yes: {s['shown']}"


def test_each_state_has_its_speed_where_that_is_not_given() -> None:
    lines = report(pair(0.012, 0.008, drive="motor"))
    assert not any(line.startswith("  speed") for line in lines)
    assert lines[2].startswith("  compensating       stable in the averaged equations at 110 rad/s (1050 rpm): b0 ")


def test_equal_balls_have_types_and_several_ways() -> None:
    result = pair(0.01, 0.01)
    lines = report(result)
    assert lines[3].startswith("  compensating (I)   stable in the averaged equations: ")
    assert {line[2:21].strip() for line in lines[3:-2]} == {"compensating (I)", "together (II)", "opposed (III)"}
    ways = [state["multiplicity"] for state in result.wucht.summary["states"]]
    assert [line.endswith(f", {count} ways") for line, count in zip(lines[3:-2], ways, strict=True)] == [c > 1 for c in ways]
    assert max(ways) == 2


def test_bodies_of_a_track_that_overlap() -> None:
    result = run(SynchronousStates(full=False), load_machine("practice/grinder-2-balls"))
    overlapping = [state["overlapping"] for state in result.wucht.summary["states"]]
    lines = [
        line for line in report(result) if "averaged equations" in line and "verdict" not in line and "assumed" not in line
    ]
    assert [line.endswith(", but bodies of a track would overlap") for line in lines] == overlapping and any(overlapping)
    impossible = "would be, could bodies overlap: a run-up shows where contacts move them"
    assert impossible in result.attrs["sentence"]


def test_what_a_state_throws_where_that_is_much_and_it_is_not_unstable() -> None:
    result = run(SynchronousStates(full=False), load_machine("practice/screen"))
    stable, unstable = result.wucht.summary["states"]
    if stable["verdict"].startswith("unstable"):
        stable, unstable = unstable, stable
    throws = [line for line in report(result) if "stroke" in line]
    assert unstable["verdict"].startswith("unstable") and unstable["machine_number"] > 0.05
    assert throws == [
        f"               stroke {1e3 * stable['stroke']:.4g} mm peak to peak at "
        f"{math.degrees(stable['throw_direction']):.1f}°, machine number {stable['machine_number']:.3g}"
    ]
    drum = pair(0.004)  # its orbit is nearly a circle: no direction
    (together,) = [state for state in drum.wucht.summary["states"] if not state["verdict"].startswith("unstable")]
    (line,) = [line for line in report(drum) if "stroke" in line]
    assert together["throw_ratio"] > 0.5 and " mm peak to peak, machine number " in line


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
    (k,) = [
        k
        for k, line in enumerate(lines)
        if "stable in the averaged, undecided in the full equations at " in line and "un" not in line[:26]
    ]
    assert lines[k + 1].startswith("               ") and "stroke" not in lines[k + 1]


def test_units_of_an_unbalance_and_of_growth() -> None:
    result = pair(0.012, 0.008)
    assert result.unbalance.attrs["units"] == result.residual_unbalance.attrs["units"] == "kg m"
    assert result.growth_slow.attrs["units"] == "1/s" and result.phase.attrs["units"] == "rad"
    bare = run(SynchronousStates(full=False), load_machine("drozdetskaya-2020/figure-5.1"))
    assert {bare[name].attrs["units"] for name in ("unbalance", "residual_unbalance", "growth_slow", "phase")} == {""}
    assert ((result.growth_slow.values < 0) == (result.stable_slow.values == 1)).all()


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
        (52.0, True, True, None),
        (54.2, None, True, "stable on 62 % of the family"),
        (55.0, False, True, "in the full equations all perturbations decay"),
        (55.6, False, None, "stable at 6 of 8 examined members of the family, not stable at this one"),
        (60.0, False, False, None),
        (68.0, True, None, "stable at 4 of 8 examined members of the family, not stable at this one"),
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
    words = "; ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items() if share)
    assert report(result)[-2] == f"  map          stable: {words}" and 0.0 in shares.values()
    assert result.map_speed.values == pytest.approx(20 + 110 / 3 * np.array([0.5, 1.5, 2.5])), "centred"
    assert result.map_ratio.values == pytest.approx([0.575, 1.325, 2.075, 2.825])
    assert not any("rows of the map" in warning for warning in result.wucht.warnings)


def test_rows_of_the_map_that_are_not_yet_computed_are_counted(tmp_path: Path) -> None:
    def stop(_share: float, what: str) -> None:
        if what == "the map":
            raise KeyboardInterrupt

    result = run(SynchronousStates(axes=AXES, full=False), machine(0.012, 0.008), folder=tmp_path, progress=stop)
    assert "0 of 4 rows of the map are computed" in result.wucht.warnings and result.wucht.summary["map"] is None


# --- limits ---


def test_a_map_needs_balancing_bodies_an_unbalance_of_the_rotor_and_few_ways_to_be_in_line() -> None:
    asked = SynchronousStates(axes=AXES, full=False)
    with refused("study.axes", "no unbalance", given=None):
        run(asked, machine(0.006, 0.006, unbalance=0.0))
    some = [0.001 + 0.0001 * k for k in range(7)]
    with refused("study.axes", "64", "128", given=None):
        run(asked, machine(*some))
    assert asked.prepare(machine(*some[:6]))[-1] is not None
    with refused("study.axes", given=None, code="no-bodies"):
        run(asked, machine(0.01))
    with refused("study.axes", given=None, code="no-bodies"):
        run(asked, load_machine("practice/screen"))
    high = 1e3 * 100.0
    for end, is_allowed in ((0.999 * high, True), (1.001 * high, False)):
        far = SynchronousStates(axes=AXES | {"speed": (20.0, end, 3)}, full=False)
        if is_allowed:
            assert far.prepare(machine(0.012, 0.008, drive=MOTOR | {"no_load_speed": 100.0}))[-1] is not None
            continue
        with refused("study.axes.speed", "1e+05 rad/s", given=[20.0, end, 3]):
            run(far, machine(0.012, 0.008, drive=MOTOR | {"no_load_speed": 100.0}))


def test_an_axis_of_a_map_has_a_width() -> None:
    for low, high, code in ((10.0, 10.0, "not-increasing"), (20.0, 10.0, "not-increasing"), (-1.0, 10.0, "negative")):
        axes = {"speed": [low, high, 5], "ratio": [0, 3, 2]}
        with refused("study.axes.speed", given=[low, high, 5], code=code):
            SynchronousStates.from_table({"kind": "synchronous-states", "axes": axes})


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


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(("speed", "is_allowed"), [(1.01e-3 * K[0], True), (0.99e-3 * K[0], False), (1.01e3 * 110.0, False)])
def test_a_given_speed_is_one_that_can_be_computed_in_either_sense(sense: float, speed: float, is_allowed: bool) -> None:
    m = machine(0.012, 0.008, drive=MOTOR)
    asked = SynchronousStates(full=False, speed=sense * speed)
    if is_allowed:
        assert run(asked, m).wucht.summary["speed"] == pytest.approx(sense * speed)
        return
    with refused("study.speed", given=sense * speed):
        run(asked, m)
