"""The lines of a search for the best balancer, and machines that it cannot vary."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import answered, five_functions, titled
from tests.refusals import refused

from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.studies.optimise_balancer.recommendation_rows import recommendation_in_words
from wucht.studies.optimise_balancer.spec import OptimiseBalancer

STUDY = five_functions("optimise-balancer")
VARIABLES = {"damping": {"unit": "N m s"}}


def point(
    time: float | None, residual: float | None, peak: float | None, captured: float | None, **other: Any
) -> dict[str, Any]:
    objectives = {"settling-time": time, "residual": residual, "peak": peak, "capture-probability": captured}
    common = {"parameters": {"damping": 0.0125}, "bodies": 2, "checked": None, "checked_undecided": 0.0, "undecided": 0.0}
    return common | {"objectives": objectives, "holds": None} | other


OWN = point(10.0, 0.02, 4e-3, 0.5)


def lines(*front: dict[str, Any], **other: Any) -> list[str]:
    summary: dict[str, Any] = {
        "sentence": "as by hand", "as_it_is": OWN, "unbalance": [0.01, 0.02], "samples": 16, "candidates": 400, "model": "slow",
        "units": {"residual": "kg m", "settling-time": "s"}, "variables": VARIABLES, "damping": None,
        "integration": "all at once",
        "objectives": ["settling-time", "residual", "peak", "capture-probability"], "front": list(front),
    } | other  # fmt: skip
    told: list[str] = STUDY.report(titled(answered(xr.Dataset(), summary, "")))
    assert told[:2] == ["A machine", "verdict: as by hand"] and told[-1] == "  integrated   all at once"
    return told[2:-1]


def test_the_lines_of_a_front() -> None:
    best = point(5.0, 0.0, 6e-3, 0.25, bodies=1)
    least = point(12.0, 0.01, 1e-3, 0.0)
    assert lines(best, least) == [
        "  searched     400 candidates, 16 runs each from random phases, unbalance 0.01 to 0.02 kg m; evaluated with "
        "the averaged equations",
        "  as it is     2 bodies, damping 0.0125 N m s: median settling time 10 s, 0.02 kg m residual unbalance, peak 4 mm, "
        "50 % captured",
        "  min settling 1 body, damping 0.0125 N m s: median settling time 5 s, 0 kg m residual unbalance, peak 6 mm, "
        "25 % captured (time -50 %, residual unbalance -100 %, peak +50 %)",
        "  min peak     2 bodies, damping 0.0125 N m s: median settling time 12 s, 0.01 kg m residual unbalance, peak 1 mm, "
        "0 % captured (time +20 %, residual unbalance -50 %, peak -75 %)",
    ]
    full = lines(best, unbalance=[0.01, 0.01], model="full", objectives=["peak"])
    assert full[0].endswith("unbalance 0.01 kg m; evaluated with the full equations")
    assert full[2].endswith("N m s: peak 6 mm (peak +50 %)") and len(full) == 3


def test_what_was_checked_counts_and_what_does_not_hold_is_left_out() -> None:
    checked = {"settling-time": 8.0, "residual": None, "peak": None, "capture-probability": 0.25}
    holds = point(1.0, 0.0, 1e-3, 0.0, checked=checked, checked_undecided=0.125, undecided=0.5, holds=True)
    wrong = point(0.5, 0.0, 1e-4, 0.0, holds=False)
    only = lines(wrong, holds, objectives=["settling-time", "capture-probability"])
    assert only[2] == (
        "  min settling 2 bodies, damping 0.0125 N m s: median settling time at least 8 s, 12.5 % to 25 % (the rest without a "
        "verdict) captured (time -20 %)"
    )
    assert len(only) == 3, "the same is told once"
    caught = lines(point(1.0, None, None, 0.125, undecided=0.25), objectives=["capture-probability"])
    assert caught[2].endswith(": 0 % to 12.5 % (the rest without a verdict) captured")
    unknown = lines(point(None, None, None, None), objectives=["peak"], as_it_is=point(None, None, None, None))
    assert unknown[1:] == ["  as it is     2 bodies, damping 0.0125 N m s: no objective is known"]


def test_the_gain_compares_checks_with_checks() -> None:
    """The check of the machine as it is needs 20 s, where its search has 10 s."""
    slower = {"settling-time": 20.0, "residual": None, "peak": None, "capture-probability": None}
    best = point(1.0, None, None, None, checked=slower | {"settling-time": 5.0}, holds=True)
    line = lines(best, as_it_is=OWN | {"checked": slower}, objectives=["settling-time"])[2]
    assert line.endswith("median settling time 5 s (time -75 %)")


def test_of_equally_good_ones_that_is_told_of_which_less_are_caught() -> None:
    front = [point(5.0, 0.0, 1e-3, 0.5, bodies=3), point(5.0, 0.0, 1e-3, 0.25, bodies=4)]
    assert lines(*front, objectives=["settling-time"])[2].startswith("  min settling 4 bodies")


def test_gains_below_half_a_percent_are_none_and_new_unbalance_is_told() -> None:
    assert lines(point(10.049, None, None, None), objectives=["settling-time"])[2].endswith("10 s")
    assert lines(point(10.051, None, None, None), objectives=["settling-time"])[2].endswith("10.1 s (time +1 %)")
    clean = point(10.0, 0.0, 1.0, 0.0)
    worse = lines(point(None, 0.01, None, None), as_it_is=clean, objectives=["residual"])
    assert worse[2].endswith("0.01 kg m residual unbalance (residual unbalance where there was none)")
    assert "where there was none" not in lines(point(None, 0.0, None, None), as_it_is=clean, objectives=["residual"])[2]
    assert "where there was none" not in lines(point(1.0, 0.1, None, None), as_it_is=clean, objectives=["settling-time"])[2]


def test_what_does_not_balance_is_not_offered_first() -> None:
    """However fast it gets through; and if nothing else is there, it says so."""
    passing, balancing = point(5.0, 0.01, 1e-3, 0.0, balances=False), point(9.0, 0.0, 2e-3, 0.0, bodies=3, balances=True)
    both = lines(passing, balancing)
    assert both[2].startswith("  min settling 3 bodies") and len(both) == 3, "it is the best in all that balances"
    alone = lines(passing)
    assert ", 0 % captured, does not balance" in alone[2]


RECOMMENDED = {
    "point": 0, "bodies": 4, "parameters": {"damping": 0.0125}, "settling_time": 40.0, "fails": 0.02, "fails_for_certain": 0.02,
    "motor_time": 30.0, "motor_sets_time": False, "changes": {},
}  # fmt: skip


def test_the_recommended_balancer() -> None:
    told = lines(recommended=RECOMMENDED)
    assert told[2] == "  recommended  4 bodies, damping 0.0125 N m s: of its runs 2 % do not end compensated" and len(told) == 3
    sure = lines(recommended=RECOMMENDED | {"fails": 0.0, "fails_for_certain": 0.0})
    assert sure[2].endswith(": of its runs all end compensated")
    assert lines(recommended=RECOMMENDED | {"fails": 0.25})[2].endswith("2 % to 25 % do not end compensated")
    motor = lines(recommended=RECOMMENDED | {"motor_time": 38.0, "motor_sets_time": True})
    assert motor[3] == "  motor        sets the settling time of 40 s, not the balancer: without vibration it needs 38 s"
    assert len(lines(recommended=None)) == 2


def test_what_to_paste_into_the_file() -> None:
    changes = {"b1.damping": "0.0125 N m s", "b1_2.damping": "0.0125 N m s"}
    pasted = lines(recommended=RECOMMENDED | {"bodies": 2, "changes": changes})[3:]
    assert pasted == [
        "  to paste     [machine.set]", '               "b1.damping" = "0.0125 N m s"',
        '               "b1_2.damping" = "0.0125 N m s"',
    ]  # fmt: skip
    more = lines(recommended=RECOMMENDED | {"changes": changes})
    assert more[3] == "  to paste     # with 4 bodies, each like the first one: b1, b1_2" and more[4:] == [
        "               [machine.set]", *pasted[1:]
    ]  # fmt: skip


def test_the_machine_as_it_is_may_be_the_recommended_one() -> None:
    told = lines(recommended=RECOMMENDED | {"point": None, "bodies": 2})
    assert told[2].startswith("  recommended  to keep the machine as it is, 2 bodies, damping 0.0125 N m s: of its runs")
    assert len(told) == 3, "nothing to paste"


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({}, "4 bodies: median settling time 40 s, 2 % fail"),
        ({"fails": 0.25}, "4 bodies: median settling time at least 40 s, 2 % to 25 % fail"),
        ({"bodies": 1, "fails": 0.0, "fails_for_certain": 0.0}, "1 body: median settling time 40 s, 0 % fail"),
    ],
)
def test_the_recommendation_in_words(more: dict[str, Any], sentence: str) -> None:
    assert recommendation_in_words(RECOMMENDED | more, "s") == sentence


@pytest.mark.parametrize(
    ("optimum", "as_many", "of_rates", "line"),
    [
        (0.25, True, None, "0.25 N m s settles fastest from random phases"),
        (
            0.25, False, 0.5,
            "0.25 N m s settles fastest from random phases, of those with the fewest captured runs; small deviations "
            "decay fastest with 0.5 N m s",
        ),
        (0.125, True, None, "0.125 N m s settles fastest from random phases, the lowest of the curve"),
        (1.0, True, None, "1 N m s settles fastest from random phases, the highest of the curve"),
    ],
)  # fmt: skip
def test_the_best_damping(optimum: float, as_many: bool, of_rates: float | None, line: str) -> None:
    damping = {"range": [0.125, 1.0], "optimum": optimum, "unit": "N m s", "as_many": as_many, "of_rates": of_rates}
    assert lines(damping=damping)[-1] == f"  damping      of the machine as it is, {line}"
    assert len(lines(damping=damping | {"optimum": None})) == 2


# --- machines ---


def machine(rotor: dict[str, Any], *dampings: float | None) -> Machine:
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "inertia": 0.03} | rotor
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.1, "length": 0.1}
    balls = [ball | {"name": f"b{k}"} | ({} if d is None else {"damping": d}) for k, d in enumerate(dampings)]
    carrier = {"mass": 1.0, "stiffness": 1e5, "damping": 200.0}
    drive = {"kind": "linear", "slope": 0.04, "no_load_speed": 500.0}
    return machine_from({"carrier": carrier, "bodies": [drum, *balls], "drive": drive})


def planned(of: Machine, **asked: Any) -> Any:
    common = {"vary": {"length": [0.05, 0.2]}, "samples": 2, "population": 20, "evaluations": 60, "points": 5, "model": "slow"}
    return STUDY.prepare(OptimiseBalancer(**common | asked), of)


def test_a_rotor_without_an_unbalance_needs_one() -> None:
    with refused("drum.unbalance", "study.unbalance", given=0.0):
        planned(machine({"unbalance": 0.0}, 0.1, 0.1))
    plan = planned(machine({"unbalance": 0.0}, 0.1, 0.1), unbalance=[0.001, 0.002])
    assert plan.as_it_is.ends == (0.001, 0.002)


def test_the_mass_of_a_rotor_with_an_eccentricity_is_not_varied() -> None:
    """Its unbalance is their product."""
    mass = {"vary": {"drum.mass": [1.0, 3.0]}}
    with refused("study.vary", given="drum.mass"):
        planned(machine({"eccentricity": 1e-3}, 0.1, 0.1), **mass)
    assert planned(machine({"unbalance": 2e-3}, 0.1, 0.1), **mass).numbers.tolist() == [2.0]
    plan = planned(machine({"eccentricity": 1e-3}, 0.1, 0.1))
    assert plan.as_it_is.ends == pytest.approx((1e-3, 1e-3))


def test_dampings_of_the_curve() -> None:
    """A decade and a half on either side of the largest, or over the range that is asked for."""
    own = machine({"unbalance": 2e-3}, 0.1, 0.4)
    trials, dampings = planned(own).curve
    assert (dampings[0], dampings[-1], len(dampings)) == (pytest.approx(0.4 * 10**-1.5), pytest.approx(0.4 * 10**1.5), 25)
    assert np.diff(np.log(dampings)) == pytest.approx(np.log(1000.0) / 24)
    assert trials.variables[0].paths == ("b0.damping", "b1.damping")
    _, asked = planned(own, vary={"damping": [0.2, 0.8]}).curve
    assert (asked[0], asked[-1]) == (pytest.approx(0.2), pytest.approx(0.8))
    _, from_zero = planned(own, vary={"damping": [0.0, 0.8]}).curve
    assert (from_zero[0], from_zero[-1]) == (pytest.approx(0.8e-3), pytest.approx(0.8))
    undamped = planned(machine({"unbalance": 2e-3}, 0.0, 0.0), inertia=True)
    assert undamped.curve is None
    none = "there is no damping curve: some balancing body has no damping that could be varied"
    assert none in undamped.warnings and none not in planned(own).warnings
    assert planned(own, damping_curve=False).curve is None and none not in planned(own, damping_curve=False).warnings
