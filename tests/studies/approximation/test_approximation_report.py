"""The words of ``approximation``: reasons not to trust, the lines of the report, and why no order is measured."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.hand_made import five_functions, titled, warnings_of, with_answer

from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.studies.approximation import computation
from wucht.studies.approximation.computation import CURVE, Errors, Findings, ModelComparison, UnmeasuredError, errors
from wucht.studies.approximation.spec import Approximation

STUDY = five_functions("approximation")
FACTORS = np.array([1.0, 0.5, 0.25, 0.125])
MEASURED = Errors(FACTORS, 0.1 * FACTORS, 1.0)


@pytest.fixture(scope="module")
def plan() -> Any:
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier").with_values({"u": 2.0})
    return STUDY.prepare(Approximation.from_table({"kind": "approximation", "along": "u", "values": [1.0, 2.0, 3.0]}), machine)


def compared(value: float = math.nan, relative: tuple[float, float] = (0.01, 0.1), **other: Any) -> ModelComparison:
    curves = np.full((2, CURVE), 1e-3)
    both = {"outcome": "captured", "slow_outcome": "captured"} | other
    return ModelComparison(value, largest=(0.02, 0.3), relative=relative, curves=curves, **both)


def trust(plan: Any, own: ModelComparison, measured: Errors | None = MEASURED, unmeasured: str = "") -> tuple[Any, list[str]]:
    s = STUDY.dataset(plan, Findings((own,), measured, unmeasured)).wucht.summary
    return s["trusted"], s["reasons"]


def test_reasons_not_to_trust(plan: Any) -> None:
    assert trust(plan, compared()) == (True, [])
    assert trust(plan, compared(slow_outcome="passed")) == (
        False,
        ["the full equations end as captured, the averaged ones as passed"],
    )
    assert trust(plan, compared(relative=(math.nan, math.nan))) == (False, ["the runs have no angle of the rotor in common"])
    assert trust(plan, compared(relative=(math.nan, 0.1)))[0] is False and trust(plan, compared(relative=(0.01, math.nan)))[0]
    apart = ["the speeds of the rotor differ by 5.1 % of the largest", "the amplitudes differ by 26 % of the largest"]
    assert trust(plan, compared(relative=(0.051, 0.26))) == (False, apart)
    assert trust(plan, compared(relative=(0.05, 0.25))) == (True, [])
    slow = Errors(FACTORS, 0.1 * FACTORS**0.69, 1.0)
    power = "their error falls with epsilon to the power 0.69, not 1: epsilon is not small"
    assert trust(plan, compared(), slow) == (False, [power])
    assert trust(plan, compared(), Errors(FACTORS, 0.1 * FACTORS**0.71, 1.0)) == (True, [])


def test_what_is_not_decided(plan: Any) -> None:
    short = "the runs are too short for an outcome; give a longer study.until"
    assert trust(plan, compared(outcome="unidentified")) == (None, [short])
    unmeasured = "whether the error falls with epsilon could not be measured: it fails"
    assert trust(plan, compared(), None, "it fails") == (None, [unmeasured])
    assert trust(plan, compared(), None) == (None, ["the study was interrupted before this was decided"])
    result = STUDY.dataset(plan, Findings((compared(), compared(1.0), compared(2.0, failure="no more"))))
    assert warnings_of(result) == [f"{result.value.attrs['long_name']} = 2: no more", "2 of 3 values are compared"]
    assert result.attrs["sentence"] == (
        "it is not decided whether full and averaged equations agree for this machine: the study was interrupted before this "
        "was decided"
    )
    result = STUDY.dataset(plan, Findings((compared(failure="own"),), None, "it fails"))
    assert warnings_of(result) == ["own", "the order of the error could not be measured: it fails"]


def test_the_lines_of_the_report(plan: Any) -> None:
    others = (compared(1.0), compared(2.0, slow_outcome="passed"), compared(3.0, slow_outcome="passed"))
    result = titled(STUDY.dataset(plan, Findings((compared(relative=(0.06, 0.1)), *others), MEASURED)), dimensionless=True)
    both = "speeds of the rotor differ by 0.02 at most, amplitudes by 0.3; "
    until = result.wucht.summary["until_phi"]
    assert STUDY.report(result) == [
        "A machine",
        "verdict: full and averaged equations do not agree for this machine: the speeds of the rotor differ by 6 % of the "
        "largest",
        f"  this machine {both}both captured",
        "  order        the error falls with epsilon to the power 1.00",
        f"  along u, up to {until:.4g} rad of the rotor's angle",
        f"    1              {both}both captured",
        f"    2              {both}captured, averaged equations passed",
        f"    3              {both}captured, averaged equations passed",
        "  the models have different outcomes from 2 to 3",
    ]


def test_the_lines_of_several_parameters_and_of_units(plan: Any) -> None:
    result = titled(STUDY.dataset(plan, Findings((compared(), compared(2.5, slow_outcome="passed")), MEASURED)))
    factor = {"factor": 2.5, "speed": None, "amplitude": None, "same_outcome": False, "outcome": "a", "slow_outcome": "b"}
    turning, shaking = ({"speed": "rad/s", "amplitude": unit} for unit in ("rad", "m"))
    several = with_answer(result, {"own": turning}, along=["a.b", "c"], deviations=[factor], disagreement=[[2.5, 2.5]])
    until = result.wucht.summary["until_phi"]
    assert STUDY.report(several)[1:] == [
        "verdict: full and averaged equations agree for this machine; the outcomes differ at u = 2.5",
        f"  this machine speeds of the rotor differ by 0.02 rad/s (0.191 rpm) at most, amplitudes by {math.degrees(0.3):.4g}°; "
        "both captured",
        "  order        the error falls with epsilon to the power 1.00",
        f"  along factor of a.b and c, up to {until:.4g} rad of the rotor's angle",
        "    2.5            nothing in common; a, averaged equations b",
        "  the models have different outcomes at 2.5",
    ]
    one = with_answer(result, {"deviations": shaking}, along_unit="N m s", trusted=None, own=None, order_of_error=None)
    assert STUDY.report(one) == [
        "A machine",
        "verdict: full and averaged equations agree for this machine; the outcomes differ at u = 2.5",
        f"  along u, up to {until:.4g} rad of the rotor's angle",
        "    2.5 N m s      speeds of the rotor differ by 0.02 rad/s (0.191 rpm) at most, amplitudes by 300 mm; "
        "captured, averaged equations passed",
        "  the models have different outcomes at 2.5 N m s",
    ]
    assert len(STUDY.report(with_answer(one, deviations=[], disagreement=[]))) == 2


def test_the_order_of_an_error_that_is_zero_is_infinite() -> None:
    assert Errors(FACTORS, np.array([1.0, 1.0, 1.0, 0.0]), 1.0).order == math.inf
    assert Errors(FACTORS, np.array([1.0, 1.0, 0.0, 0.0]), 1.0).order == math.inf
    assert Errors(FACTORS, np.array([9.0, 9.0, 0.8, 0.1]), 1.0).order == pytest.approx(3.0)


# --- why there is no order ---


def unmeasured(plan: Any, **changes: Any) -> str:
    with pytest.raises(UnmeasuredError) as raised:
        errors(plan.spec, changes.get("machine", plan.machine), Work())
    return str(raised.value)


def test_schedules_do_not_become_slower(plan: Any) -> None:
    machine = SimpleNamespace(schedules=("one",))
    why = "the times of schedules do not scale with epsilon"
    assert unmeasured(plan, machine=machine) == why


def test_why_there_is_no_order(plan: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(computation, "compared_bodies", lambda _: [])
        assert unmeasured(plan) == "at 1 epsilon all speeds are prescribed"
    real = computation.integrate
    with monkeypatch.context() as patch:
        patch.setattr(computation, "integrate", lambda *of, **more: replace(real(*of, **more), failure="it burst"))
        assert unmeasured(plan) == "at 1 epsilon the slow equations fail: it burst"
    calls = []

    def second_fails(*of: Any, **more: Any) -> Any:
        calls.append(of)
        return replace(real(*of, **more), failure="it burst") if of[0] is not calls[0][0] else real(*of, **more)

    with monkeypatch.context() as patch:
        patch.setattr(computation, "integrate", second_fails)
        assert unmeasured(plan) == "at 1 epsilon the full equations fail: it burst"
    with monkeypatch.context() as patch:
        seen = SimpleNamespace(states=np.full((9, 2000), np.nan))
        patch.setattr("wucht.dynamics.run_ups.run_up_models.SlowModel.machine_motion", lambda *_: seen)
        assert unmeasured(plan) == "at 1 epsilon the averaged equations have no finite motion"


# --- the figure ---


def drawn(plan: Any, *compared: ModelComparison) -> list[Any]:
    result = titled(STUDY.dataset(plan, Findings(compared, MEASURED)), dimensionless=True)
    axes: list[Any] = STUDY.figure(result).axes
    return axes


def test_criteria_are_shares_of_the_largest_and_only_drawn_where_there_is_one(plan: Any) -> None:
    speed, amplitude, along, _ = drawn(plan, compared(), compared(1.0), compared(3.0))
    assert speed.get_lines()[-1].get_ydata()[0] == pytest.approx(0.05 * 0.02 / 0.01)
    assert amplitude.get_lines()[-1].get_ydata()[0] == pytest.approx(0.25 * 0.3 / 0.1)
    limit = along.get_lines()[-1]
    assert (limit.get_label(), limit.get_ydata().tolist()) == ("5 % of the largest speed", pytest.approx([0.1, 0.1]))
    assert (along.get_yscale(), along.get_xscale()) == ("log", "linear")
    none = (math.nan, math.nan)
    speed, amplitude, along, _ = drawn(plan, compared(relative=none), compared(1.0, none), compared(30.0, none))
    assert [len(axis.get_lines()) for axis in (speed, amplitude)] == [3, 3]
    assert [line.get_label() for line in along.get_lines()][1:] == ["same outcome"]
    assert along.get_xscale() == "log"


def test_what_does_not_deviate_is_not_drawn_by_its_logarithm(plan: Any) -> None:
    same = [replace(compared(v, (0.0, 0.0)), largest=(0.0, 0.0), curves=np.zeros((2, CURVE))) for v in (math.nan, 1.0, 3.0)]
    axes = drawn(plan, *same)
    assert [axis.get_yscale() for axis in axes[:3]] == ["linear"] * 3
    assert [len(axis.get_lines()) for axis in axes[:3]] == [3, 3, 2]
