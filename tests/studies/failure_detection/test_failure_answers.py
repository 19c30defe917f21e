"""What is said of a failure of a rotor alone, which takes a second: sentences, warnings, lines and panels; other values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

import wucht
from wucht.dynamics.exciters.speed_readings import FEWEST

WHOLE = 1e5
SENSOR: dict[str, Any] = {"interval": 0.1, "noise": 1.0, "false_alarm_every": 1e4}
LINE = {"k": 5, "ND": 10, "SD": "8 mm"}
FAILURE = {"remaining": 0.8, "direction": "x", "woehler": LINE}
SLOPES = {"along": "drive.slope", "range": (0.002, 0.005), "points": 2}
DAMPINGS = {"second": "carrier.damping", "second_range": (50.0, 70.0), "second_points": 2}


def rotor(*points: tuple[float, float]) -> wucht.Machine:
    p = wucht.parts
    schedule = {"parameter": "carrier.stiffness", "points": list(points)}
    return wucht.Machine(
        p.Carrier(mass=5.0, directions="xy", stiffness=WHOLE, damping=60.0),
        [p.Rotor(name="drum", mass=5.0, unbalance=5e-3, inertia=4e-3)],
        [p.LinearDrive(slope=0.004, no_load_speed=150.0)],
        schedules=[schedule] if points else [],
    )


FALLS = rotor((4.0, WHOLE), (4.5, 0.9 * WHOLE))
STILL_MOVING = "after the failure the motion is still transient: run at least until 20 s"


def failed(machine: wucht.Machine = FALLS, sensor: dict[str, Any] | None = None, **keys: Any) -> xr.Dataset:
    question = {"until": 8.0, "after": 2.0, "sensor": SENSOR | (sensor or {})} | keys
    return wucht.run(wucht.FailureDetection(**question), machine)


def close(result: xr.Dataset) -> list[str]:
    """Its warnings but for the one that the run is short."""
    return [warning for warning in result.wucht.warnings if warning != STILL_MOVING]


@pytest.fixture(scope="module")
def fall() -> xr.Dataset:
    return failed()


def test_the_readings_are_those_of_the_run_up(fall: xr.Dataset) -> None:
    """Their noise is that of the seed alone; the extremes of a reading begin after the sample before it."""
    noise = fall.reading.values - fall.speed.values
    assert noise == pytest.approx(np.random.default_rng(0).normal(size=80), abs=1e-9)
    run = wucht.run(wucht.RunUp(until=8.0), FALLS)
    time, x = run.time.values, run.displacement.sel(direction="x").values
    for end, high, low in zip(fall.reading_time.values, fall.highest.values, fall.lowest.values, strict=True):
        inside = x[(time > end - 0.1) & (time <= end)]
        if end > 2.0:  # from then on each has a reversal of both kinds
            assert (high, low) == (pytest.approx(inside.max(), abs=2e-4), pytest.approx(inside.min(), abs=2e-4))


def test_why_there_is_no_chart() -> None:
    result = failed(sensor={"change": 20.0})
    (warning,) = close(result)
    assert warning.endswith("even the lowest threshold gives fewer false alarms than requested: request rarer ones")
    s = result.wucht.summary
    assert s["chart"] is None and s["delay"] is None and "seen" not in result
    assert not {"chart", "detection"} & {line[2:13].strip() for line in wucht.report(result)}
    assert len(wucht.draw(result).axes) == 3


def test_a_run_that_is_not_accurate() -> None:
    result = failed(tolerance=1e-4)
    (warning,) = close(result)
    assert result.wucht.summary["energy_residual"] > 1e-6 and warning.startswith("the energy balance closes only to")


def test_a_chart_for_larger_changes(fall: xr.Dataset) -> None:
    change = abs(fall.wucht.summary["change"])
    assert close(failed(sensor={"change": 0.999 * change})) == []
    (warning,) = close(failed(sensor={"change": 1.001 * change}))
    assert warning.startswith("the chart is designed for changes of")


def test_a_failure_that_is_seen_no_sooner_than_a_false_alarm() -> None:
    """From half of the time between false alarms on; it is told in hours, too."""
    for noise, is_seen in ((63.0, True), (65.0, False)):
        result = failed(sensor={"noise": noise})
        mean = result.wucht.summary["delay"]["mean"]
        assert (mean < 5000.0) is is_seen
        late = "an alarm comes hardly any sooner than a false one: the chart does not detect this failure"
        assert (late in result.wucht.warnings) is not is_seen
        assert f"detected {mean:.0f} s ({mean / 3600:.3g} h) later on average" in result.wucht.sentence


def test_a_gradual_failure_that_is_seen_before_it() -> None:
    gradual = {"failure": FAILURE | {"law": "linear", "remaining": 0.9}, "after": 1.0, "learning": 1.5}
    result = failed(rotor(), {"noise": 0.2}, until=7.0, **gradual)
    mean = result.wucht.summary["delay"]["mean"]
    assert mean < 0 and result.wucht.sentence.endswith(f"which is detected {-mean:.4g} s before it on average")


# --- other values ---


@pytest.mark.slow
def test_the_signal_over_one_parameter() -> None:
    """Between two slopes, and four times halfway between the best one and its neighbour; as a machine of that slope has it."""
    shares = list[float]()
    question = wucht.FailureDetection(until=7.0, after=2.0, sensor=SENSOR, **SLOPES)
    result = wucht.run(question, FALLS, progress=lambda share, _: shares.append(share))
    assert result.signal.dims == ("along",) and result.along.values.tolist() == sorted(result.along.values.tolist())
    assert {0.002, 0.005, 0.0035} <= set(result.along.values.round(6)) and 6 <= result.along.size <= 10
    assert shares == sorted(shares)
    assert min(share for share in shares if share > 0.3) == pytest.approx(0.35, abs=0.05), "the machine itself takes a third"
    largest, k = result.wucht.summary["largest"], int(np.argmax(result.signal.values))
    known = result.along.values[k], result.signal.values[k], result.change.values[k]
    assert (largest["drive.slope"], largest["signal"], largest["change"]) == known
    alone = failed(FALLS.with_values({"drive.slope": 0.005}), until=7.0).wucht.summary
    assert (result.signal.values[-1], result.change.values[-1]) == (alone["signal"], alone["change"])
    line, star = wucht.draw(result).axes[-1].get_lines()
    assert list(line.get_xdata()) == result.along.values.tolist() and list(star.get_ydata()) == [largest["signal"]]


def test_the_signal_over_two_parameters() -> None:
    result = failed(until=7.0, **SLOPES, **DAMPINGS)
    assert result.signal.dims == ("along", "second") and result.second.attrs["long_name"] == "carrier.damping"
    assert result.signal.shape == (2, 2) and result.along.values.tolist() == [0.002, 0.005], "the grid alone"
    largest = result.wucht.summary["largest"]
    assert largest["signal"] == result.signal.values.max() == float(result.signal.sel(along=0.002, second=50.0))
    assert [n["carrier.damping"] for n in largest["neighbours"]] == [50.0, 70.0]
    labels = [line.get_label() for line in wucht.draw(result).axes[-1].get_lines()]
    assert labels == ["carrier.damping = 50", "carrier.damping = 70", "largest"]
    assert any(line.startswith("  largest ") for line in wucht.report(result))


def test_a_largest_signal_at_a_cliff_is_warned_of() -> None:
    """With a little weaker motor the specimen does not fail in time."""
    result = failed(rotor(), failure=FAILURE, after=0.5, along="drive.slope", range=(0.00325, 0.0034), points=2)
    cliff = result.wucht.summary["largest"]["cliff"]
    assert np.isnan(result.signal.values[0]) and cliff["signal"] == 0.0 and -0.05 < cliff["distance"] < 0
    distance = f"{-100 * cliff['distance']:.2g} % below"
    assert any(f"lies at a cliff: {distance}" in w for w in result.wucht.warnings)
    assert result.wucht.sentence.endswith(f", and {distance} that 0")
    assert f"cliff, {distance} it" in [line.get_label() for line in wucht.draw(result).axes[-1].get_lines()]


# --- schedules ---


@pytest.mark.parametrize("at", [0.0, 8.0, 9.0])
def test_a_fall_at_the_beginning_or_at_the_end_of_the_run_is_refused(at: float) -> None:
    before = [] if at == 0.0 else [(0.0, WHOLE)]
    with refused("study.until", given=8.0):
        failed(rotor((-1.0, WHOLE), *before, (at, 0.8 * WHOLE)))


@pytest.mark.parametrize(
    ("keys", "most"),
    [({"after": 0.5}, 1.75 / FEWEST), ({"after": 3.0}, 1.0 / FEWEST), ({"after": 1.0, "learning": 1.0}, 1.0 / FEWEST)],
)
def test_there_are_enough_readings_before_the_fall_and_in_half_of_the_time_after_it(keys: dict[str, Any], most: float) -> None:
    """Until the fall at 4 s, and from 6.25 s to 8 s."""
    failed(sensor={"interval": 0.99 * most}, **keys)
    with refused("study.sensor.interval", f"{most:.4g}", given=1.01 * most):
        failed(sensor={"interval": 1.01 * most}, **keys)


def test_the_speed_is_learnt_until_the_fall_at_the_latest() -> None:
    with refused("study.after", "4", given=3.0):
        failed(after=3.0, learning=1.01)
    assert failed(after=3.0, learning=1.0).wucht.summary["before"]["speed"] > 0


def test_a_failure_by_damage_of_which_too_few_readings_are_left() -> None:
    at = failed(rotor(), failure=FAILURE, after=0.5).wucht.summary["failure_time"]
    late = failed(rotor(), failure=FAILURE, after=0.5, until=at + 0.3)
    assert late.wucht.summary["failure_time"] == pytest.approx(at, abs=0.05) and late.wucht.summary["change"] is None
    (warning,) = late.wucht.warnings
    assert warning.startswith("there are too few readings before or after the failure")
    assert not {"after", "change"} & {line[2:13].strip() for line in wucht.report(late)}
