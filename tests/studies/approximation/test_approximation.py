"""The study approximation: deviations over a parameter, regions where the models differ, the order of the error, and trust."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal, refused

from wucht import Approximation, Machine, draw, load_machine, report, run
from wucht.dynamics.scenarios.order_of_error import FACTORS, Errors, UnmeasuredError, measured_errors, nominal_order
from wucht.dynamics.work import Work
from wucht.machines.schedules import schedules_of

TABLE_3_1 = "drozdetskaya-2020/table-3.1-carrier"
DRUM_START = {"p1": 0.3, "p2": -0.5}


def ask(**keys: Any) -> Approximation:
    return Approximation.from_table({"kind": "approximation", **keys})


def answer(machine: Machine, **keys: Any) -> tuple[xr.Dataset, dict[str, Any]]:
    result = run(ask(**keys), machine)
    return result, result.wucht.summary


def measured(machine: Machine, **keys: Any) -> Errors:
    question = ask(**keys)
    return measured_errors(machine, question.start, question.settings, question.until_phi, Work())


@pytest.fixture(scope="module")
def rotor() -> Machine:
    return load_machine(TABLE_3_1).with_values({"u": 2.0})


@pytest.fixture(scope="module")
def drum() -> Machine:
    return load_machine("drozdetskaya-2020/r1")


# Keys


SPACED = {
    "a decade": ({"range": [0.1, 1.0], "points": 3}, [0.1, math.sqrt(0.1), 1.0]),
    "a decade, linear": ({"range": [0.1, 1.0], "points": 3, "spacing": "linear"}, [0.1, 0.55, 1.0]),
    "less, log": ({"range": [1.0, 4.0], "points": 3, "spacing": "log"}, [1.0, 2.0, 4.0]),
    "from 0": ({"range": [0.0, 4.0], "points": 2}, [0.0, 4.0]),
    "default": ({"range": [1.0, 7.0]}, [1, 2, 3, 4, 5, 6, 7]),
    "values": ({"values": [3.0, 1.0, 3.0]}, [1.0, 3.0]),
}


@pytest.mark.parametrize(("keys", "expected"), SPACED.values(), ids=SPACED.keys())
def test_values_of_the_range(rotor: Machine, keys: dict[str, Any], expected: list[float]) -> None:
    turning = {rotor.rotor.name: {"speed": 1.0}}  # also with no drive at all
    own, *values = (value for value, _ in ask(along="u", start=turning, **keys).prepare(rotor))
    assert math.isnan(own)
    assert values == pytest.approx(expected, rel=1e-12)


def test_one_factor_of_several_parameters() -> None:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    question = ask(along=["beta_p", "beta_r"], values=[0.5])
    own, half = (case.machine.values for _, case in question.prepare(machine))
    assert own == machine.values
    assert half == {**machine.values, "beta_p": 0.5, "beta_r": pytest.approx(0.05)}


REFUSED: dict[str, dict[str, Any]] = {
    "along": {"along": "p1.name", "values": [1]},
    "along nothing": {"along": [], "values": [1]},
    "along twice": {"along": ["p1.mass", "p1.mass"], "values": [1]},
    "along alone": {"along": "p1.mass"},
    "range alone": {"range": [1, 2]},
    "both": {"along": "p1.mass", "values": [1], "range": [1, 2]},
    "order of the range": {"along": "p1.mass", "range": [2, 1]},
    "range in seconds": {"along": "p1.mass", "range": ["1 s", "2 s"]},
    "factor in kg": {"along": ["p1.mass", "p2.mass"], "range": ["1 kg", "2 kg"]},
    "no values": {"along": "p1.mass", "values": []},
    "points": {"along": "p1.mass", "range": [1, 2], "points": 1},
    "log from 0": {"along": "p1.damping", "range": [0, 2], "spacing": "log"},
    "angle 0": {"until_phi": 0},
    "order": {"order": 3},
    "a mass below 0": {"along": "p1.mass", "values": [-1]},
    "no damping": {"along": "p1.damping", "values": [0, 1], "inertia": False},
    "no drive": {"along": "drive.slope", "values": [0, 1]},
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_wrong_question(drum: Machine, case: str) -> None:
    """Before anything is computed."""
    check_refusal(f"approximation: {case}", lambda: ask(start=DRUM_START, **REFUSED[case]).prepare(drum))


def test_machines_without_slow_equations_are_refused() -> None:
    machine = load_machine("sperling-vibration/figure-7")
    with refused("machine", code="slider"):
        ask(start={"disc": {"speed": 9.0}}).prepare(machine)


# What it finds


def test_trusted(rotor: Machine) -> None:
    """Table 3.1 has epsilon = 0.01 and one free body: both captured, the error falls with epsilon."""
    result, summary = answer(rotor, along="u", values=[1.0, 2.6])
    assert summary["trusted"], summary["reasons"]
    assert summary["own"]["outcome"] == summary["own"]["slow_outcome"] == "captured"
    assert summary["order_of_error"] == pytest.approx(1.0, abs=0.1)
    assert [d["u"] for d in summary["deviations"]] == [1.0, 2.6]
    assert result.value.values[:-1] == pytest.approx([1.0, 2.6])
    assert np.isnan(result.value.values[-1]), "the machine's own values come last, without a value"
    # The curves end at until_phi, and their maximum is the number reported.
    assert float(result.angle[-1]) == 100.0
    largest = np.nanmax(result.speed_over_angle.values, axis=1)
    assert largest == pytest.approx(result.speed_deviation.values, rel=0.02)
    assert (largest <= result.speed_deviation.values * (1 + 1e-12)).all()
    assert result.attrs["finished"] == 1
    assert not result.wucht.warnings


@pytest.mark.slow
def test_not_trusted_with_light_damping() -> None:
    """002, 5.6.2: sigma of the size of epsilon. The speeds part by 0.23 of 2, and the models end differently."""
    machine = load_machine("drozdetskaya-2020/table-5.1").with_values({"sigma": 0.01})
    result, summary = answer(machine, start={"psi": 0.0, "delta": 0.5}, until=1500.0)
    assert not summary["trusted"]
    assert any("the speeds of the rotor differ by" in r for r in summary["reasons"])
    assert any("the full equations end" in r for r in summary["reasons"])
    assert "do not agree" in result.attrs["sentence"]


@pytest.mark.slow
def test_with_a_prescribed_speed_the_bodies_are_compared() -> None:
    """The rotor's speed has no deviation then; its rollers go another way in the averaged equations, and arrive elsewhere."""
    machine = load_machine("sperling-rollers/figure-8")
    result, summary = answer(machine, start={"r1": 0.1, "r2": -0.1})
    assert summary["speeds_of"] == "the bodies"
    assert result.speed_deviation.attrs["long_name"] == "largest deviation of the speed of the bodies"
    assert summary["own"]["speed"] > 1.0
    assert summary["trusted"] is False
    assert any("the amplitudes differ by" in r for r in summary["reasons"])


def test_without_an_order_nothing_is_trusted(rotor: Machine) -> None:
    """Agreement at one epsilon is no proof: 002, 5.6, varies it. A schedule does not become slower with epsilon."""
    steady = [{"parameter": "u", "points": [[0, 2.0], [1, 2.0]]}]
    machine = rotor.with_fields(schedules=schedules_of(steady, rotor.parameters, rotor.parts, ""))
    result, summary = answer(machine, until=700.0)
    reason = "the times of schedules do not scale with epsilon"
    assert summary["trusted"] is None
    assert summary["reasons"] == [f"whether the error falls with epsilon could not be measured: {reason}"]
    assert (summary["order_of_error"], summary["nominal_order"], summary["errors"]) == (None, None, None)
    assert result.wucht.warnings == [f"the order of the error could not be measured: {reason}"]
    assert "not decided" in result.attrs["sentence"]
    assert len(draw(result).axes) == 2


def test_exciters_have_the_root_of_epsilon_as_their_small_parameter() -> None:
    """Nothing damps them against each other: they librate with it."""
    assert nominal_order(load_machine("sperling-vibration/self-synchronisation-soft"), 1) == 0.5
    assert nominal_order(load_machine(TABLE_3_1), 2) == 2.0


def test_too_short_to_tell(rotor: Machine) -> None:
    _, summary = answer(rotor, until=100.0)
    assert not summary["trusted"]
    assert summary["own"]["same_outcome"] is None
    assert "too short" in summary["reasons"][0]


@pytest.mark.slow
def test_the_order_of_a_shaken_machine_and_with_a_prescribed_speed_is_positive() -> None:
    """001, 2.1: at kappa times epsilon the shaking's torque must be kappa times as large too, or the problem is another one.

    Where the rotor's speed is prescribed it has no error: what is measured is that of its rollers.
    """
    shaken = measured(load_machine("sperling-vibration/figure-2a"))
    assert shaken.speed[-1] < 0.5 * shaken.speed[0]
    assert 0.5 < shaken.order < 1.5
    rollers = measured(load_machine("sperling-rollers/figure-8"), start={"r1": 0.1, "r2": -0.1})
    assert (np.diff(rollers.speed) < 0).all()
    assert 0.5 < rollers.order < 2


def test_a_long_angle_keeps_the_runs_in_proportion(rotor: Machine) -> None:
    """The longest run, at an eighth of epsilon, is one of 20 000 rad."""
    long, longer = (measured(rotor, until_phi=angle) for angle in (2500.0, 1e4))
    assert long.speed.tolist() == longer.speed.tolist() != measured(rotor, until_phi=2000.0).speed.tolist()


def test_no_order_where_the_rotor_does_not_turn_far_enough() -> None:
    """A drive that only just moves: 8 doublings of the time do not reach the angle."""
    machine = load_machine(TABLE_3_1).with_values({"u": 1e-7})
    with pytest.raises(UnmeasuredError, match=r"at 1 epsilon the rotor does not turn through 100 rad"):
        measured(machine)


# Comparisons


def test_the_order_of_the_error(rotor: Machine) -> None:
    """It falls with epsilon to its power; that of the second order is smaller from the beginning."""
    errors = list[np.ndarray]()
    for order in (1, 2):
        _, summary = answer(rotor, order=order, until=300.0)
        errors.append(np.array([*summary["errors"].values()]))
        assert [*map(float, summary["errors"])] == [*FACTORS] and (np.diff(errors[-1]) < 0).all()
        assert summary["order_of_error"] == pytest.approx(order, abs=0.1) and summary["nominal_order"] == order
    assert (errors[1] < 0.2 * errors[0]).all()


@pytest.mark.parametrize(
    ("epsilon", "reasons"),
    [
        (0.006, []),
        (0.0085, ["amplitudes"]),
        (0.01, ["amplitudes"]),
        (0.012, ["speeds of the rotor", "amplitudes"]),
    ],
)
def test_both_sides_of_what_is_trusted(rotor: Machine, epsilon: float, reasons: list[str]) -> None:
    """5 % of the largest speed, 25 % of the largest amplitude."""
    result, summary = answer(rotor.with_values({"epsilon": epsilon}), until=400.0)
    speed, amplitude = (float(result[f"relative_{of}_deviation"][-1]) for of in ("speed", "amplitude"))
    assert (speed > 0.05, amplitude > 0.25) == ("speeds of the rotor" in reasons, "amplitudes" in reasons)
    told = [next(of for of in ("speeds of the rotor", "amplitudes") if of in reason) for reason in summary["reasons"]]
    assert (summary["trusted"], told) == (not reasons, reasons)


@pytest.fixture(scope="module")
def along_epsilon(rotor: Machine) -> xr.Dataset:
    return run(ask(along="epsilon", values=[0.002, 0.05, 0.1], until=1000.0), rotor)


def test_values_at_which_the_models_end_differently(along_epsilon: xr.Dataset) -> None:
    """The verdict is on the nominal values, the last ones, alone."""
    result, s = along_epsilon, along_epsilon.wucht.summary
    assert s["trusted"] is True
    assert result.attrs["sentence"].endswith("; the outcomes differ at epsilon = 0.05, 0.1")
    assert result.value.values == pytest.approx([0.002, 0.05, 0.1, math.nan], nan_ok=True)
    assert result.same_outcome.values.tolist() == [1, 0, 0, 1]
    assert [d["same_outcome"] for d in s["deviations"]] == [True, False, False] and s["disagreement"] == [[0.05, 0.1]]
    assert [d["epsilon"] for d in s["deviations"]] == [0.002, 0.05, 0.1]
    rows = [*s["deviations"], s["own"]]
    for of in ("speed", "amplitude"):
        assert [row[of] for row in rows] == result[f"{of}_deviation"].values.tolist()
    assert [row["outcome"] for row in rows] == result.outcome.values.tolist() == ["captured", "passed", "passed", "captured"]
    assert [row["slow_outcome"] for row in rows] == result.slow_outcome.values.tolist() == ["captured"] * 4
    assert list(s["errors"].values()) == result.error.values.tolist() and result.factor.values.tolist() == list(FACTORS)
    assert (s["along"], s["along_unit"], s["until_phi"], result.attrs["nominal"]) == ("epsilon", "", 100.0, 0.001)
    ends = np.diff(result.angle.values)
    assert draw(result).axes and report(result)
    assert result.angle.values[[0, -1]].tolist() == [0.0, 100.0] and ends == pytest.approx(ends[0])


def test_the_order_of_an_error_that_is_zero_is_infinite() -> None:
    assert Errors(np.array(FACTORS), np.array([1.0, 1.0, 1.0, 0.0]), 1.0).order == math.inf


# Stopping and resuming


COUNT = 4  # parts of the same weight: the machine as it is, two values, and the order of the error


def stopping_in(part: float) -> Callable[[float, str], None]:
    """Ctrl-C, once a part has begun."""

    def stop(share: float, _: str) -> None:
        if COUNT * share > part:
            raise KeyboardInterrupt

    return stop


@pytest.mark.parametrize("done", [0, 2])
def test_ctrl_c_leaves_a_valid_result(rotor: Machine, done: int) -> None:
    result = run(ask(along="u", values=[1.0, 2.0], until=300.0), rotor, progress=stopping_in(done))
    summary = result.wucht.summary
    assert result.attrs["finished"] == 0
    assert result.sizes["value"] == done
    assert summary["trusted"] is None
    assert summary["reasons"] == ["the study was interrupted before this was decided"]
    assert (summary["own"] is None) == (done == 0)
    assert [d["u"] for d in summary["deviations"]] == [1.0, 2.0][: max(done - 1, 0)]
    progress, interrupted = result.wucht.warnings
    assert progress == f"{max(done - 1, 0)} of 2 values are compared"
    assert interrupted.startswith("interrupted")
    assert len(draw(result).axes) == 2 + (result.sizes["value"] > 1), "no panels of what is not there yet"


@pytest.mark.parametrize("part", [1.5, 3.5])
def test_resumed_it_is_the_uninterrupted_one(rotor: Machine, tmp_path: Path, part: float) -> None:
    """To the last bit, and what was compared or measured is not computed again."""
    question = ask(along="u", values=[1.0, 2.0], until=300.0)
    run(question, rotor, folder=tmp_path, progress=stopping_in(part))
    shares = list[float]()
    result = run(question, rotor, folder=tmp_path, resume=True, progress=lambda share, _: shares.append(COUNT * share))
    assert not [share for share in shares if share < int(part) and not share.is_integer()]
    assert [share for share in shares if int(part) < share < int(part) + 1], "what was interrupted is"
    # The parts of the order are as long as their runs: 1, 2, 4 and 8 of 15.
    assert part < 3 or not [share for share in shares if 3.0 < share < 3 + 7 / 15 - 1e-9]
    whole = run(question, rotor)
    assert result.wucht.summary == whole.wucht.summary
    assert list(result.variables) == list(whole.variables)
    for name in whole.variables:
        assert np.array_equal(result[name], whole[name], equal_nan=whole[name].dtype.kind == "f"), name
    assert result.attrs["finished"] == 1
    assert "interrupted" not in result.attrs["warnings"]
