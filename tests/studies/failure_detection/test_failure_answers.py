"""What is said of a failure of a rotor alone, which takes a second: sentences, warnings, lines and panels; other values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

import wucht
from interrupting import stop_at
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


@pytest.fixture(scope="module")
def damaged() -> xr.Dataset:
    return failed(rotor(), failure=FAILURE, after=0.5)


def test_the_lines_of_a_failure(fall: xr.Dataset) -> None:
    s = fall.wucht.summary
    before, after, averaged, delay = s["before"], s["after"], s["averaged"], s["delay"]
    assert wucht.report(fall)[1:-1] == [
        f"verdict: the specimen fails at 4 s, the speed changes by {s['change']:.4g} rad/s, which is detected "
        f"{delay['mean']:.4g} s later on average",
        f"  before       {before['speed']:.6g} rad/s, unidentified; averaged equations {averaged['before']:.6g} rad/s",
        f"  after        {after['speed']:.6g} rad/s, unidentified; averaged equations {averaged['after']:.6g} rad/s",
        f"  change       {s['change']:.5g} rad/s, {s['signal']:.4g} times the standard deviation of the readings, "
        f"{s['deviation']:.4g} rad/s",
        f"  chart        cumulative sum, k = {s['chart']['reference']:.4g}, h = {s['chart']['threshold']:.4g} rad/s",
        f"  detection    {delay['mean']:.4g} s after the failure on average; half of them within {delay['half']:.4g} s, "
        f"19 of 20 within {delay['nearly_all']:.4g} s",
        f"  stiffness    0.9 of the intact specimen's at the end, its work {s['stiffness_work']:.4g} J",
        f"  energy       closes to {s['energy_residual']:.1e}",
    ]
    assert (before["speed"] + s["change"], s["signal"]) == pytest.approx((after["speed"], -s["change"] / s["deviation"]))
    assert fall.wucht.warnings == [STILL_MOVING] and s["damage"] is None and s["averaged"]["kinds"] == ["beating motion"] * 2
    assert s["averaged"]["change"] == averaged["after"] - averaged["before"] == pytest.approx(s["change"], abs=0.03)


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
    reason = "even the lowest threshold gives fewer false alarms than requested: request rarer ones"
    assert close(result) == [f"there is no control chart: {reason}"]
    assert result.wucht.sentence.endswith(
        f"changes by {result.wucht.summary['change']:.4g} rad/s; no control chart monitors it"
    )
    s = result.wucht.summary
    assert s["chart"] is None and s["delay"] is None and "seen" not in result
    assert not {"chart", "detection"} & {line[2:13].strip() for line in wucht.report(result)}
    assert len(wucht.draw(result).axes) == 3


def test_a_run_that_is_not_accurate() -> None:
    result = failed(tolerance=1e-4)
    residual = result.wucht.summary["energy_residual"]
    assert residual > 1e-6 and close(result) == [f"the energy balance closes only to {residual:.1e}: the run is not accurate"]


def test_a_chart_for_larger_changes(fall: xr.Dataset) -> None:
    change = abs(fall.wucht.summary["change"])
    assert close(failed(sensor={"change": 0.999 * change})) == []
    assert close(failed(sensor={"change": 1.001 * change})) == [
        f"the chart is designed for changes of {1.001 * change:.3g}, and this one is smaller: a smaller study.sensor.change "
        "detects it sooner"
    ]


def test_a_failure_that_is_seen_no_sooner_than_a_false_alarm() -> None:
    """From half of the time between false alarms on; it is told in hours, too."""
    for noise, is_seen in ((63.0, True), (65.0, False)):
        result = failed(sensor={"noise": noise})
        mean = result.wucht.summary["delay"]["mean"]
        assert (mean < 5000.0) is is_seen
        late = "an alarm comes hardly any sooner than a false one: the chart does not detect this failure"
        assert (late in result.wucht.warnings) is not is_seen
        assert f"detected {mean:.0f} s ({mean / 3600:.3g} h) later on average" in result.wucht.sentence


def test_a_speed_that_is_measured_too_early(fall: xr.Dataset) -> None:
    """While the rotor still runs up; the averaged equations give the speed that it approaches."""
    result = failed(sensor={"interval": 0.02, "false_alarm_every": 1e9}, after=0.0, learning=0.3)
    (warning,) = close(result)
    assert warning == (
        f"the averaged equations have {result.wucht.summary['averaged']['before']:.5g} before the failure, the full ones "
        f"{result.wucht.summary['before']['speed']:.5g}: the speed is still changing, the averaged motion is a different one, "
        "or the averaging is too coarse"
    )


def test_a_failure_by_damage(damaged: xr.Dataset) -> None:
    s = damaged.wucht.summary
    lines = {line[2:13].strip(): line[15:] for line in wucht.report(damaged)}
    assert lines["damage"] == f"{s['damage']:.5g} at the end" and lines["stiffness"].startswith("0.8 of the intact")
    late = failed(rotor(), failure=FAILURE, after=0.5, until=s["failure_time"] + 0.3)
    assert late.wucht.sentence == (
        f"the specimen fails at {s['failure_time']:.6g} s; there are too few readings to determine the change of speed"
    )
    few = "there are too few readings before or after the failure: run longer, or let the specimen fail later"
    assert late.wucht.warnings == [few]
    assert [line[2:13].strip() for line in wucht.report(late)[2:-1]] == [
        "before", "chart", "detection", "damage", "stiffness", "energy",
    ]  # fmt: skip


def test_what_is_known_before_the_failure() -> None:
    """Of a run that is interrupted."""
    part = wucht.run(
        wucht.FailureDetection(until=20.0, after=2.0, sensor=SENSOR), rotor((15.0, WHOLE), (16.0, 9e4)), progress=stop_at(70)
    )
    assert part.wucht.sentence == "the specimen does not fail" and not part.wucht.finished
    assert part.wucht.warnings[0].startswith("the specimen does not fail within study.until: run longer")
    assert wucht.report(part)[2].endswith("not classified")
    assert [line.get_label() for line in wucht.draw(part).axes[-1].get_lines()] == ["stiffness, share of the initial one"]


def test_the_panels(damaged: xr.Dataset) -> None:
    speed, load, alarm, stiffness = wucht.draw(damaged).axes
    s, failure_time = damaged.wucht.summary, float(damaged.failure_time)
    levels = [(line.get_label(), line.get_ydata()[0]) for line in speed.get_lines()[2:4]]
    assert levels[0] == ("averaged equations", s["averaged"]["before"]) and levels[1][1] == s["averaged"]["after"]
    assert str(levels[1][0]).startswith("_")
    assert list(speed.get_lines()[1].get_ydata()) == damaged.speed.values.tolist()
    assert list(speed.get_lines()[0].get_ydata()) == damaged.reading.values.tolist()
    for axis in (speed, load, stiffness):
        (failure,) = [line for line in axis.get_lines() if line.get_label() == "failure"]
        assert failure.get_xdata()[0] == failure_time
    step, marks, mean = alarm.get_lines()
    assert list(step.get_ydata()) == list(marks.get_ydata()) == damaged.seen.values[: len(step.get_ydata())].tolist()
    assert mean.get_xdata()[0] == s["delay"]["mean"]
    drawn = [list(line.get_ydata()) for line in stiffness.get_lines()[:2]]
    assert drawn == [damaged.stiffness.values.tolist(), damaged.damage.values.tolist()]
    assert alarm.get_ylim() == (0.0, 1.02) and stiffness.get_ylim()[0] == 0.0


def test_a_gradual_failure_that_is_seen_before_it() -> None:
    gradual = {"failure": FAILURE | {"law": "linear", "remaining": 0.9}, "after": 1.0, "learning": 1.5}
    result = failed(rotor(), {"noise": 0.2}, until=7.0, **gradual)
    mean = result.wucht.summary["delay"]["mean"]
    assert mean < 0 and result.wucht.sentence.endswith(f"which is detected {-mean:.4g} s before it on average")


# --- other values ---


def test_the_signal_over_one_parameter() -> None:
    """Between two slopes, and four times halfway between the best one and its neighbour; as a machine of that slope has it."""
    shares = list[float]()
    question = wucht.FailureDetection(until=7.0, after=2.0, sensor=SENSOR, **SLOPES)
    result = wucht.run(question, FALLS, progress=lambda share, _: shares.append(share))
    assert result.signal.dims == ("along",) and result.along.values.tolist() == sorted(result.along.values.tolist())
    assert {0.002, 0.005, 0.0035} <= set(result.along.values.round(6)) and 6 <= result.along.size <= 10
    assert (result.along.attrs["long_name"], result.along.attrs["units"]) == ("drive.slope", "N m s")
    assert result.change.attrs["units"] == "rad/s" and shares == sorted(shares)
    assert min(share for share in shares if share > 0.3) == pytest.approx(0.35, abs=0.05), "the machine itself takes a third"
    largest = result.wucht.summary["largest"]
    k = int(np.argmax(result.signal.values))
    assert (largest["drive.slope"], largest["signal"], largest["change"]) == (
        result.along.values[k], result.signal.values[k], result.change.values[k],
    )  # fmt: skip
    alone = failed(FALLS.with_values({"drive.slope": 0.005}), until=7.0).wucht.summary
    assert (result.signal.values[-1], result.change.values[-1]) == (alone["signal"], alone["change"])
    assert result.wucht.sentence.endswith(
        f"; the signal is largest, {largest['signal']:.3g} ({result.wucht.summary['signal']:.3g} as it is), at drive.slope = "
        f"{largest['drive.slope']:.4g}"
    )
    axis = wucht.draw(result).axes[-1]
    line, star = axis.get_lines()
    assert (line.get_label(), list(line.get_xdata())) == ("signal", result.along.values.tolist())
    assert (star.get_label(), list(star.get_ydata())) == ("largest", [largest["signal"]])
    assert axis.get_ylim()[0] == 0 and axis.get_title() == "signal at the failure" and len(axis.get_xticks()) <= 7
    assert axis.get_ylabel() == "change of speed / standard deviation"


def test_the_signal_over_two_parameters() -> None:
    result = failed(until=7.0, **SLOPES, **DAMPINGS)
    assert result.signal.dims == ("along", "second") and result.second.attrs["long_name"] == "carrier.damping"
    assert result.signal.shape == (2, 2) and result.along.values.tolist() == [0.002, 0.005], "the grid alone"
    largest = result.wucht.summary["largest"]
    at = f"drive.slope = {largest['drive.slope']:.5g}, carrier.damping = {largest['carrier.damping']:.5g}"
    assert wucht.report(result)[-2] == (
        f"  largest      signal {largest['signal']:.4g} at {at}: change {largest['change']:.5g} rad/s, "
        f"then {largest['outcome']}"
    )
    assert largest["signal"] == result.signal.values.max() == float(result.signal.sel(along=0.002, second=50.0))
    assert [n["carrier.damping"] for n in largest["neighbours"]] == [50.0, 70.0]
    labels = [line.get_label() for line in wucht.draw(result).axes[-1].get_lines()]
    assert labels == ["carrier.damping = 50", "carrier.damping = 70", "largest"]


def test_a_largest_signal_at_a_cliff_is_warned_of() -> None:
    """With a little weaker motor the specimen does not fail in time."""
    result = failed(rotor(), failure=FAILURE, after=0.5, along="drive.slope", range=(0.00325, 0.0034), points=2)
    largest, signal = result.wucht.summary["largest"], f"{result.wucht.summary['largest']['signal']:.3g}"
    cliff = largest["cliff"]
    assert np.isnan(result.signal.values[0]) and cliff["signal"] == 0.0 and -0.05 < cliff["distance"] < 0
    distance = f"{-100 * cliff['distance']:.2g} % below"
    warning = next(w for w in result.wucht.warnings if "cliff" in w)
    assert warning.startswith(
        f"the largest signal, {signal} at drive.slope = {largest['drive.slope']:.5g} N m s, lies at a cliff: {distance}, at "
        f"{cliff['value']:.5g} N m s, it is 0"
    )
    assert result.wucht.sentence.endswith(f"at drive.slope = {largest['drive.slope']:.4g}, and {distance} that 0")
    labels = [line.get_label() for line in wucht.draw(result).axes[-1].get_lines()]
    assert labels[:3] == ["signal", "largest", f"cliff, {distance} it"]


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
