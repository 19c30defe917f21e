"""The lines of ``synchronous-states``, and what its run says of families and of the end of the search."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import five_functions, titled, warnings_of, with_answer
from tests.refusals import refused

from wucht.analysis.configurations.averaged_stability import REGIONS, Regions, Stability
from wucht.analysis.configurations.full_stability import FullStability
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.studies.runner import run
from wucht.studies.synchronous_states.dataset import _map_quantities as of_map
from wucht.studies.synchronous_states.spec import SynchronousStates

STUDY = five_functions("synchronous-states")
BALL = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
HELD = {"kind": "constant-speed", "speed": 100.0}
DC_SERIES = {
    "kind": "dc-series", "voltage": 100.0, "armature_resistance": 2, "field_resistance": 1, "field_inductance": 0.5,
    "motor_constant": 0.5,
}  # fmt: skip


def machine(*unbalances: float, drive: dict[str, Any] = HELD, **rotor: Any) -> Machine:
    balls = [BALL | {"name": f"b{k}", "mass": u / 0.5} for k, u in enumerate(unbalances)]
    carrier = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": [40.0, 60.0]}
    return machine_from({"carrier": carrier, "bodies": [ROTOR | rotor, *balls], "drive": drive})


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return run(SynchronousStates(full=False), machine(0.012, 0.008))


def state(**other: Any) -> dict[str, Any]:
    """An entry of the summary."""
    entry = {
        "name": "compensating", "type": None, "speed": 100.0, "phases": {"b0": math.radians(120.0), "b1": 2 * math.pi - 1e-9},
        "stable_slow": True, "stable_full": True, "residual_share": None, "family_dimension": 0, "multiplicity": 1,
        "verdict": "stable", "overlapping": False, "why": None,
    }  # fmt: skip
    return entry | other


def lines(result: xr.Dataset, *states: dict[str, Any], **other: Any) -> list[str]:
    made = with_answer(result, **{"states": list(states), "full": True, "complete": True, "shown": "as by hand"} | other)
    report: list[str] = STUDY.report(made)
    return report


def test_the_lines_of_a_machine_whose_speed_is_given(result: xr.Dataset) -> None:
    told = lines(result, state(), sentence="one of them")
    assert told == [
        result.attrs["title"],
        "verdict: one of them",
        "  speed        100 rad/s (955 rpm), given",
        "  compensating       stable: b0 120.00°, b1 0.00°",
        "  complete     yes: as by hand",
    ]


def test_each_state_has_its_speed_where_that_is_not_given(result: xr.Dataset) -> None:
    told = lines(result, state(speed=50.0), state(speed=100.0), speed=None, complete=False)
    assert told[2:] == [
        "  compensating       stable at 50 rad/s (477 rpm): b0 120.00°, b1 0.00°",
        "  compensating       stable at 100 rad/s (955 rpm): b0 120.00°, b1 0.00°",
        "  complete     not proved: as by hand",
    ]


@pytest.mark.parametrize(
    ("other", "line"),
    [
        ({"name": None}, "no name            stable: b0 120.00°, b1 0.00°"),
        ({"type": "II"}, "compensating (II)  stable: b0 120.00°, b1 0.00°"),
        ({"residual_share": 0.12345}, "compensating       stable: b0 120.00°, b1 0.00°, 12.3 % of the unbalance remains"),
        ({"residual_share": 0.0}, "compensating       stable: b0 120.00°, b1 0.00°, 0 % of the unbalance remains"),
        ({"multiplicity": 2}, "compensating       stable: b0 120.00°, b1 0.00°, 2 ways"),
        (
            {"multiplicity": 2, "family_dimension": 1},
            "compensating       stable: b0 120.00°, b1 0.00°, one of a family of dimension 1",
        ),
        (
            {"overlapping": True},
            "compensating       stable: b0 120.00°, b1 0.00°, but bodies of a track would overlap",
        ),
        ({"stable_slow": False, "stable_full": False}, "compensating       unstable: b0 120.00°, b1 0.00°"),
        ({"stable_slow": None, "stable_full": None}, "compensating       undecided: b0 120.00°, b1 0.00°"),
        (
            {"stable_full": False},
            "compensating       stable in the averaged, unstable in the full equations: b0 120.00°, b1 0.00°",
        ),
        (
            {"stable_slow": None},
            "compensating       undecided in the averaged, stable in the full equations: b0 120.00°, b1 0.00°",
        ),
    ],
)
def test_the_line_of_a_state(result: xr.Dataset, other: dict[str, Any], line: str) -> None:
    assert lines(result, state(**other))[3:-1] == [f"  {line}"]


def test_without_multipliers_stability_is_that_of_the_averaged_equations(result: xr.Dataset) -> None:
    told = lines(result, state(stable_slow=False, stable_full=None, why="they were not asked for"), full=False)
    assert told[3:-1] == ["  compensating       unstable in the averaged equations: b0 120.00°, b1 0.00°"]
    assert lines(result, state(why="because"))[4] == "               because"


def test_what_a_state_throws_where_that_is_much_and_it_is_not_unstable(result: xr.Dataset) -> None:
    throw = {"machine_number": 3.456, "stroke": 8.12345e-3, "throw_direction": math.pi / 4, "throw_ratio": 0.2}
    line = "stroke 8.123 mm peak to peak at 45.0°, machine number 3.46"
    assert lines(result, state(**throw))[4:-1] == [f"               {line}"]
    assert lines(result, state(**throw | {"throw_ratio": 0.5}))[4:-1] == [f"               {line.replace(' at 45.0°', '')}"]
    assert len(lines(result, state(**throw | {"machine_number": 0.049}))) == 5
    assert len(lines(result, state(**throw | {"machine_number": 0.05}))) == 6
    assert len(lines(result, state(**throw | {"verdict": "unstable"}))) == 5
    assert len(lines(result, state(**throw | {"verdict": "undecided"}))) == 6


def test_of_too_many_states_those_that_are_stable_are_named(result: xr.Dataset) -> None:
    some = [state(name=f"s{k}", verdict="stable" if k == 25 else "unstable") for k in range(26)]
    told = lines(result, *some)
    assert [line.split()[0] for line in told[3:-2]] == [*(f"s{k}" for k in range(23)), "s25"]
    assert told[-2] == "  and 2 more: see the Dataset"
    assert len(lines(result, *some[:24])) == 3 + 24 + 1


def test_which_shares_of_the_map_are_stable(result: xr.Dataset) -> None:
    shares = {"compensating": 0.256, "together": 0.0, "none": 0.744}
    assert lines(result, map={"stable_share": shares})[-1] == "  map          stable: compensating 26 %; none 74 %"


# --- the search, families, the map ---


def test_a_drive_that_runs_away_leaves_the_end_of_the_range_to_the_program() -> None:
    m = machine(0.012, 0.008, drive=DC_SERIES)
    plan = STUDY.prepare(SynchronousStates(full=False), m)
    shown = STUDY.dataset(plan, list(STUDY.run(plan, Work()))[-1]).wucht.summary
    assert plan.is_limit_chosen and not shown["complete"]
    assert shown["shown"].endswith(
        "; these are all in this range, but its upper end is the program's choice, as the drive runs away without load: "
        "study.range sets another"
    )


@pytest.mark.parametrize(
    ("first", "others", "stable", "reason"),
    [
        (True, [True] * 7, True, ""),
        (True, [None] * 7, True, ""),
        (None, [True, False] * 3 + [True], None, ""),
        (
            True, [True, False, None, True, True, False, True], None,
            "stable at 5 of 7 examined members of the family, stable at this one",
        ),
        (
            False, [True, None, None, None, None, None, None], None,
            "stable at 1 of 2 examined members of the family, not stable at this one",
        ),
    ],
)  # fmt: skip
def test_a_family_is_judged_by_its_members(
    monkeypatch: pytest.MonkeyPatch, first: bool | None, others: list[bool | None], stable: bool | None, reason: str
) -> None:
    answers, phases = iter([first, *others]), []

    def judged(_: FullStability, of: Any) -> Stability:
        phases.append(of.phases)
        return Stability(next(answers), np.array([-1.0 + 2.0j]), "")

    monkeypatch.setattr(FullStability, "stability", judged)
    monkeypatch.setattr(FullStability, "disagreement", lambda *_: None)
    plan = STUDY.prepare(SynchronousStates(), machine(0.006, 0.006, unbalance=0.0))
    *_, findings = STUDY.run(plan, Work())
    (family,) = findings.configurations
    assert (family.full.stable, family.full.reason) == (stable, reason)
    assert family.full.exponents.tolist() == [-1.0 + 2.0j]
    assert len(phases) == 8 and len({tuple(np.round(p, 6)) for p in phases}) == 8


def test_rows_of_the_map_that_are_not_yet_computed_are_counted() -> None:
    axes = {"speed": (20.0, 130.0, 3), "ratio": (0.2, 3.2, 4)}
    plan = STUDY.prepare(SynchronousStates(axes=axes, full=False), machine(0.012, 0.008))
    *_, findings = STUDY.run(plan, Work())
    assert warnings_of(STUDY.dataset(plan, findings)) == []
    regions = findings.map
    part = Regions(regions.speed, regions.ratio[:3], regions.stable[:, :3], regions.exists[:, :3])
    assert warnings_of(STUDY.dataset(plan, replace(findings, map=part))) == ["3 of 4 rows of the map are computed"]
    assert warnings_of(STUDY.dataset(plan, replace(findings, map=None))) == ["0 of 4 rows of the map are computed"]
    assert STUDY.report(titled(STUDY.dataset(plan, findings)))[-1].startswith("  map          stable: ")


def test_a_map_needs_an_unbalance_of_the_rotor_and_few_ways_to_be_in_line() -> None:
    axes = {"speed": (20.0, 130.0, 3), "ratio": (0.2, 3.2, 4)}
    with refused("study.axes", "no unbalance", given=None):
        STUDY.prepare(SynchronousStates(axes=axes, full=False), machine(0.006, 0.006, unbalance=0.0))
    some = [0.001 + 0.0001 * k for k in range(7)]
    with refused("study.axes", "64", "128", given=None):
        STUDY.prepare(SynchronousStates(axes=axes, full=False), machine(*some))
    assert STUDY.prepare(SynchronousStates(axes=axes, full=False), machine(*some[:6])).map is not None


def test_the_share_of_the_map_without_a_stable_state() -> None:
    stable = np.zeros((4, 2, 5), bool)
    stable[0, 0, :3] = stable[1, 0, 2:4] = True
    regions = Regions(np.arange(1.0, 6.0), np.array([1.0, 2.0]), stable, ~stable)
    named = {q.name: q for q in of_map(regions, "rad/s")}
    shares = named["map"].value["stable_share"]
    assert shares == pytest.approx({"none": 0.6} | dict(zip(REGIONS, (0.3, 0.2, 0.0, 0.0), strict=True)))
    assert named["map_stable"].value[0].sum() == 3 and named["map_exists"].value[0].sum() == 7
