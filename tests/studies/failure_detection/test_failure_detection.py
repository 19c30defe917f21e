"""What the study says of a failure, against simulation, the averaged equations and another study."""

from __future__ import annotations

import numpy as np
import pytest
from test_failing_machine import LINE, SENSOR, START, WHOLE, exciter, failed

import wucht
from interrupting import assert_same, stop_at
from wucht import draw, report
from wucht.measurements.cusum import Cusum
from wucht.studies.study_file import read_study

EXAMPLE = "drozdetskaya-2020/failure-of-the-specimen"
MAP = "drozdetskaya-2020/where-the-failure-is-seen-best"


def example(name=EXAMPLE, **settings):
    study = read_study(name, {f"study.{key}": value for key, value in settings.items()})
    return wucht.run(study.spec, study.subject)


@pytest.fixture(scope="module")
def catalogue():
    return example()


def test_the_exciter_falls_out_of_its_resonance(catalogue):
    """002, 6.2. Before, the averaged equations beat at a speed 4 % lower; after, the bodies compensate at the no-load speed."""
    s = catalogue.wucht.summary
    assert (s["before"]["outcome"], s["after"]["outcome"]) == ("captured-modulated", "compensated")
    assert s["failure_time"] == 20.5
    assert s["before"]["speed"] == pytest.approx(94.5755, abs=2e-3)
    assert s["averaged"]["before"] == pytest.approx(91.06, abs=0.05)
    assert s["after"]["speed"] == pytest.approx(200.0, abs=1e-4)
    assert s["averaged"]["after"] == pytest.approx(200.0, abs=1e-9)
    assert s["averaged"]["kinds"] == ["beating motion", "steady state"]
    assert s["energy_residual"] < 1e-9
    # The displacement of the carrier when it fails is known from the turning points: no more than 9.5 mm of amplitude.
    assert -2e4 / 2 * 9.5e-3**2 <= s["stiffness_work"] < 0
    assert catalogue.wucht.warnings == []


def test_the_delay_by_simulation(catalogue):
    """The chart on the study's own readings with drawn noise: when it alarms after the failure, having not done so before."""
    s, noise = catalogue.wucht.summary, 2.0
    time, speed = catalogue["reading_time"].values, catalogue["speed"].values
    random, made = np.random.default_rng(8), Cusum(s["chart"]["reference"], s["chart"]["threshold"], noise)
    kept = time > 8.0
    deviations = speed[kept] - s["chart"]["mean"] + random.normal(0, noise, (4000, int(kept.sum())))
    first = time[kept][made.first_alarms(deviations)] - s["failure_time"]
    assert (first > 0).all(), "in 12 s there is no false alarm where one comes in ten days"
    assert s["delay"]["mean"] == pytest.approx(first.mean(), abs=4 * first.std() / np.sqrt(4000) + 0.02)
    assert s["delay"]["half"] == pytest.approx(np.quantile(first, 0.5, method="inverted_cdf"))
    assert s["delay"]["nearly_all"] == pytest.approx(np.quantile(first, 0.95, method="inverted_cdf"))


def test_false_alarms_of_the_beating_speed(catalogue):
    """A chart for rare alarms on the readings as they come: simulated at one that alarms often."""
    often = example(**{"sensor.false_alarm_every": "200 s", "until": "30 s"})
    s, time = often.wucht.summary, often["reading_time"].values
    normal = often["speed"].values[(time > 8.4) & (time <= s["failure_time"])] - s["chart"]["mean"]
    readings = np.tile(normal, 250) + np.random.default_rng(9).normal(0, 2.0, (1500, 250 * len(normal)))
    first = Cusum(s["chart"]["reference"], s["chart"]["threshold"], 2.0).first_alarms(readings) + 1
    assert 0.5 * first.mean() == pytest.approx(200.0, abs=4 * 0.5 * first.std() / np.sqrt(1500))
    assert catalogue.wucht.summary["chart"]["threshold"] > 1.2 * s["chart"]["threshold"]


def single():
    """An exciter with one pendulum, which hangs in its resonance and does not beat; its stiffness falls to 90 %."""
    p = wucht.parts
    drum = p.Rotor(name="drum", mass=9.75, eccentricity=1e-3, inertia=9.75e-4)
    pendulum = p.Pendulum(name="p1", about="drum", mass=0.125, length=0.104, inertia=1.69e-3, damping=0.169)
    schedule = {"parameter": "carrier.stiffness", "points": [(30.0, WHOLE), (31.0, 0.9 * WHOLE)]}
    motor = p.LinearDrive(slope=0.000975, no_load_speed=200.0)
    return wucht.Machine(p.Carrier(stiffness=WHOLE, damping=200.0), [drum, pendulum], [motor], schedules=[schedule])


def test_a_steady_speed_is_that_of_the_averaged_equations():
    """Held below the resonance by the weak motor: the speed follows sqrt(c); both speeds are steady states of the averaging."""
    sensor = SENSOR | {"interval": 0.25, "noise": 1.0, "false_alarm_every": 1e5, "change": 3.0}
    s = failed(single(), until=60.0, after=24.0, start={"p1": 0.3}, sensor=sensor).wucht.summary
    assert (s["before"]["outcome"], s["after"]["outcome"]) == ("captured", "captured")
    assert s["averaged"]["kinds"] == ["steady state", "steady state"]
    assert s["before"]["speed"] == pytest.approx(s["averaged"]["before"], rel=2e-5)
    assert s["after"]["speed"] == pytest.approx(s["averaged"]["after"], rel=2e-5)
    assert s["change"] == pytest.approx(-2.974, abs=0.005)
    assert s["signal"] == pytest.approx(2.974, rel=0.01), "nothing beats: of the noise alone"
    # By the chart's theory a jump by 3 standard deviations is seen 2.3 readings later, a ramp of a second half a second later.
    assert 0.5 < s["delay"]["mean"] < 2.0


def test_what_does_not_fail_is_said():
    result = failed(exciter(), failure={"remaining": 0.8, "direction": "x", "woehler": LINE | {"ND": 1e9}}, until=4.0)
    s = result.wucht.summary
    assert s["failure_time"] is None and s["change"] is None and s["delay"] is None
    assert 0 < s["damage"] < 1e-4 and s["stiffness"] == 1.0
    assert any("does not fail within study.until" in w for w in result.wucht.warnings)
    assert draw(result).axes and report(result)


@pytest.mark.parametrize(("remaining", "cycles", "fails"), [(0.9, 60, True), (0.5, 400, False)])
def test_a_gradual_loss(remaining, cycles, fails):
    """The stiffness falls from the begin on. A small loss ends with D = 1; a large one drives the exciter out of its resonance,
    where the specimen is spared: it does not fail, and that is seen."""
    sensor = SENSOR | {"noise": 0.2, "interval": 0.5, "false_alarm_every": 3600.0, "change": 2.0}
    own = {"failure": {"remaining": remaining, "law": "linear", "direction": "x", "woehler": LINE | {"ND": cycles}}}
    result = failed(exciter(), **own, sensor=sensor, after=1.0, learning=6.0, until=30.0)
    s = result.wucht.summary
    assert (s["failure_time"] is not None) == fails
    assert s["before"]["outcome"] is not None
    if fails:
        assert s["stiffness"] == pytest.approx(remaining)
    else:
        assert s["damage"] < 0.5 and s["after"]["speed"] > 180
        assert 0 < s["delay"]["half"] <= s["delay"]["nearly_all"] < 10
        assert result["alarm_time"].attrs["long_name"] == "time since the chart begins"
        assert "after the chart begins on average; half" in "".join(report(result))


@pytest.mark.slow
def test_the_horizon_grows_until_it_is_known_when_it_is_seen():
    """A quarter of the noise is seen after hours; by simulation 11,605 +- 58 readings in the mean, and 8,130 in half of all."""
    weak = exciter((0.0, WHOLE), (40.0, 0.98 * WHOLE)).with_values({"drive.slope": 0.000975})
    sensor = {"interval": 0.5, "noise": 2.0, "false_alarm_every": 240 * 3600.0}
    result = failed(weak, until=80.0, after=20.0, sensor=sensor)
    delay = result.wucht.summary["delay"]
    assert delay["mean"] / 0.5 == pytest.approx(11_605, abs=4 * 58)
    assert delay["half"] / 0.5 == pytest.approx(8_130, rel=0.03)
    assert delay["half"] < delay["nearly_all"] < delay["horizon"] == result["alarm_time"][-1]
    assert delay["readings"] == delay["horizon"] / 0.5 and delay["probability"] == pytest.approx(0.9999, abs=1e-6)
    lines = report(result)
    assert lines[1].endswith("which is detected 5770 s (1.6 h) later on average")
    assert not any("never" in line or "not within" in line for line in lines)


@pytest.mark.slow
def test_the_signal_is_largest_where_the_exciter_just_falls_out():
    """The edge is where the study sweep finds that the softened machine leaves its resonance, from a slow rise of the motor."""
    result = example(MAP)
    s, signal, slope = result.wucht.summary, result["signal"].values, result["along"].values
    edge = int(np.flatnonzero(np.diff(signal) > 10)[0])
    assert s["largest"]["drive.slope"] == slope[edge + 1] == pytest.approx(0.013125)
    assert s["largest"]["signal"] == pytest.approx(21.842, abs=0.01)
    assert (signal[: edge + 1] < 2).all() and (np.diff(signal[edge + 1 :]) < 0).all()
    soft = wucht.load_machine("drozdetskaya-2020/r1").with_values({"carrier.stiffness": 8e4, "p2.mass": 0.126})
    sweep = wucht.Sweep(along="drive.slope", range=(0.012, 0.014), direction="up", start=START)
    [jump] = wucht.run(sweep, soft).wucht.summary["jumps"]
    assert slope[edge] - 1e-5 < jump["drive.slope"] < slope[edge + 1] + 1e-5


@pytest.mark.slow
def test_other_values_over_two_parameters_resumed(tmp_path):
    """Stopped three times, it ends with the same numbers; each place is what the machine with these values gives alone."""
    machine = exciter((4.0, WHOLE), (4.1, 0.8 * WHOLE))
    keys = {
        "until": 7.5, "start": START, "sensor": SENSOR, "after": 1.0, "along": "drive.slope", "range": (0.005, 0.02),
        "points": 2, "second": "carrier.damping", "second_range": (190.0, 210.0), "second_points": 2,
    }  # fmt: skip
    question = wucht.FailureDetection(**keys)
    whole = wucht.run(question, machine)
    result = wucht.run(question, machine, folder=tmp_path, progress=stop_at(20))
    stops = 1
    while not result.attrs["finished"]:
        result = wucht.run(question, machine, folder=tmp_path, resume=True, progress=stop_at(60 + 60 * stops))
        stops += 1
    assert 2 < stops < 8
    assert_same(whole, result)
    alone = failed(machine.with_values({"drive.slope": 0.02, "carrier.damping": 190.0}), until=7.5, after=1.0)
    assert float(whole["signal"].sel(along=0.02, second=190.0)) == pytest.approx(alone.wucht.summary["signal"], rel=1e-9)
    s = whole.wucht.summary
    assert s["largest"]["signal"] == pytest.approx(float(whole["signal"].max()))
    assert any(line.startswith("  largest") and "carrier.damping" in line for line in report(whole))
