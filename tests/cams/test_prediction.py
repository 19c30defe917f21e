"""The predicted speed: against closed forms, against integration in time, the balance of power, convergence, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import ellipe
from tests.refusals import failed

from wucht.cams import prediction
from wucht.cams.confirmation import confirmation
from wucht.cams.correction import CorrectedLaw, MotionOverTime, Purity, orders, share_above_order
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.prediction import CamShaft, Torque
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries, even_angles

TURN = 2 * math.pi
LAW = equiripple(5, math.radians(120), math.radians(24))
FASTEST = float(np.abs(LAW(np.linspace(0, TURN, 20001), 1)).max())
SINE = FourierSeries.of(0.0, [], [1.0])  # psi'^2 = cos^2 phi
J0, OMEGA = 2.0, 50.0
TAU = even_angles(512)
METHODS = ["motion_with_cam", "motion_with_corrected_cam"]


@pytest.fixture
def points(monkeypatch):
    """Sets the number of collocation points: so many are enough for these laws, and all that is tried."""

    def chosen(count):
        monkeypatch.setattr(prediction, "_FEWEST", count)
        monkeypatch.setattr(prediction, "_MOST", count)

    return chosen


def line(slope, free=OMEGA):
    """A drive whose torque falls by so much for each rad/s, and is none at a speed."""
    return lambda v: (slope * (free - v), np.full(np.shape(v), -slope))


def motor_and_fan(v):
    """An asynchronous motor after Kloss with a fan that brakes it."""
    slip, top, at = 1 - v / 60.0, 3000.0, 0.4
    below = slip**2 + at**2
    return 2 * top * at * slip / below - 0.3 * v**2, -2 * top * at * (at**2 - slip**2) / (below**2 * 60.0) - 0.6 * v


def shaft(ratio, torque=None, mean_speed=OMEGA):
    """With J1 max psi'^2/J0 as asked for LAW."""
    return CamShaft(J0, ratio * J0 / FASTEST**2, mean_speed, torque)


def kinetic_energy_of_the_original(of, law, motion):
    phi = motion.angle(TAU)
    return (of.inertia + of.output_inertia * law(phi, 1) ** 2) * motion.speed(TAU) ** 2 / 2


def kinetic_energy_of_the_corrected(of, law, motion):
    return of.inertia * motion.speed(TAU) ** 2 / 2 + of.output_inertia * (motion.mean * law(TAU, 1)) ** 2 / 2


def settled(of, law, turns):
    """The mean speed, and phi and phi' at times TAU of a turn, integrated over time from an even speed so many turns before."""

    def slope(_, y):
        first, second = law(y[0], 1), law(y[0], 2)
        pull = float(of.torque(y[1])[0]) - of.output_inertia * first * second * y[1] ** 2
        return y[1], pull / (of.inertia + of.output_inertia * first**2)

    def begun(_, y):
        return y[0] - turns * TURN

    def ended(_, y):
        return y[0] - (turns + 1) * TURN

    ended.terminal = True
    span, begin = (0, 3 * (turns + 1) * TURN / of.mean_speed), [0.0, of.mean_speed]
    run = solve_ivp(slope, span, begin, "DOP853", rtol=1e-11, atol=1e-11, events=[begun, ended], dense_output=True)
    (begin,), (end,) = run.t_events
    assert run.y_events[0][0][1] == pytest.approx(run.y_events[1][0][1], rel=1e-9)  # the motion has become periodic
    phi, speed = run.sol(begin + (end - begin) * TAU / TURN)
    return TURN / (end - begin), phi - turns * TURN, speed


@pytest.mark.parametrize("ratio", [0.11, 0.76])
def test_energy_of_the_eigenmotion_is_constant_and_its_mean_speed_as_asked(ratio):
    of = shaft(ratio)
    for method, energy in zip(METHODS, (kinetic_energy_of_the_original, kinetic_energy_of_the_corrected), strict=True):
        found = getattr(of, method)(LAW)
        assert found.mean == pytest.approx(OMEGA, rel=1e-13)
        assert found.angle(TURN) == pytest.approx(TURN, rel=1e-14)
        kinetic = energy(of, LAW, found)
        assert kinetic == pytest.approx(np.full(512, kinetic.mean()), rel=1e-10)
        assert found.fluctuation > 0.3 * ratio  # which is not how a shaft turns that stores nothing


@pytest.mark.parametrize("ratio", [0.5, 1.5, 2.0])
def test_eigenmotion_is_that_of_the_elliptic_integral(ratio):
    """psi = sin tau: the mean of sqrt(x - kappa cos^2 tau) is sqrt(x) E(kappa/x) 2/pi, of sqrt(1 + kappa cos^2) likewise."""
    of = CamShaft(1.0, ratio, OMEGA)
    found = of.motion_with_cam(SINE)
    kinetic = (OMEGA * math.sqrt(1 + ratio) * ellipe(ratio / (1 + ratio)) * 2 / math.pi) ** 2 / 2
    assert kinetic_energy_of_the_original(of, SINE, found) == pytest.approx(np.full(512, kinetic), rel=1e-12)
    kinetic = kinetic_energy_of_the_corrected(of, SINE, of.motion_with_corrected_cam(SINE))
    x = 2 * kinetic.mean() / OMEGA**2
    assert kinetic == pytest.approx(np.full(512, kinetic.mean()), rel=1e-9)
    assert math.sqrt(x) * ellipe(ratio / x) * 2 / math.pi == pytest.approx(1, abs=1e-9)


@pytest.mark.slow
def test_with_a_torque_it_is_what_integration_over_time_settles_to():
    of = shaft(0.76, line(100.0))
    found = of.motion_with_cam(LAW)
    mean, phi, speed = settled(of, LAW, 12)
    assert found.mean == pytest.approx(mean, rel=1e-9)
    assert np.abs(found.speed(TAU) - speed).max() < 1e-8 * mean
    assert np.abs(found.angle(TAU) - phi).max() < 1e-8
    assert found.fluctuation > 0.1


@pytest.mark.parametrize("torque", [motor_and_fan, line(3000.0, 61.0)], ids=["motor and fan", "stiff line"])
@pytest.mark.parametrize("method", METHODS)
def test_drive_and_load_do_no_work_over_a_turn(method, torque, points):
    points(128)
    found = getattr(shaft(0.5, torque), method)(LAW)
    speed = found.speed(TAU)
    power = torque(speed)[0] * speed
    assert abs(power.mean()) < 1e-9 * np.abs(power).max()
    assert np.abs(power).max() > 100


def cut_and_measured(of, cams):
    """What is left with the original cam, with that corrected for the speed measured with it, and so on."""
    left, cam = [], LAW
    for _ in range(cams):
        share, measured = of.residual_with_cam(cam, Purity.from_law(LAW, 5))
        left.append(share)
        cam = CorrectedLaw(LAW, measured)
    return left


def test_measuring_and_cutting_contracts_about_as_the_inertia_ratio(points):
    """cam-mathematics: from 0.26 to 0.036 of order 1 at a ratio of 0.11, from 1.17 to 0.78 at 0.76."""
    points(128)
    found = cut_and_measured(shaft(0.11, line(100.0)), 3)
    assert found[:2] == pytest.approx([0.26, 0.036], rel=0.02)
    assert 0.08 < found[2] / found[1] < 0.14
    found = cut_and_measured(shaft(0.76, line(100.0)), 3)
    assert found[:2] == pytest.approx([1.17, 0.78], rel=0.06)
    assert 0.5 < found[2] / found[1] < 0.76


def test_a_cam_that_is_corrected_beforehand_is_its_own_successor(points):
    """Cut for the speed that is measured with it, it is cut as it is; and the output has no orders above the law's."""
    points(128)
    of = shaft(0.11, line(100.0))
    direct = of.motion_with_corrected_cam(LAW)
    cam = CorrectedLaw(LAW, direct)
    again = of.motion_with_cam(cam)
    assert again.speed(TAU) == pytest.approx(direct.speed(TAU), rel=1e-11)
    assert share_above_order(orders(MotionOverTime(cam, again)), 5) < 1e-9


def test_up_to_which_inertia_ratio_there_is_a_corrected_cam_without_a_drive(points):
    """No law has less than 1; a corrected cam is found just below it, and none just above."""
    assert CamShaft.most_inertia_ratio(SINE) == pytest.approx(math.pi**2 / 4, rel=1e-5)
    points(256)
    most = CamShaft.most_inertia_ratio(LAW)
    assert most == pytest.approx(1.29, abs=0.01)
    assert shaft(0.99 * most).motion_with_corrected_cam(LAW).mean == pytest.approx(OMEGA)
    with failed("comes-to-rest"):
        shaft(1.01 * most).motion_with_corrected_cam(LAW)


def test_power_at_constant_speed_is_what_changes_the_energy_of_the_output():
    of = CamShaft(J0, 3.0, 40.0)
    power = of.power_at_constant_speed(LAW)
    tau = even_angles(len(power))
    changes = FourierSeries.from_samples(3.0 * (40.0 * LAW(tau, 1)) ** 2 / 2).derivative()(tau) * 40.0  # d/dt = omega d/dtau
    assert power == pytest.approx(changes, abs=1e-10 * np.abs(changes).max())
    assert abs(power.mean()) < 1e-13 * power.max()
    assert CamShaft(J0, 3.0, 80.0).power_at_constant_speed(LAW) == pytest.approx(8 * power)
    assert of.power_at_constant_speed(LAW, 64) == pytest.approx(power[:: len(power) // 64])
    assert CamShaft(7.0, 6.0, 40.0).power_at_constant_speed(LAW) == pytest.approx(2 * power)


def test_the_inertia_ratio_is_that_of_the_greatest_speed():
    assert CamShaft(4.0, 3.0, OMEGA).inertia_ratio(FourierSeries.of(0.7, [], [0.2])) == pytest.approx(0.03, rel=1e-12)
    slope = LAW.derivative()
    assert CamShaft(4.0, 3.0, OMEGA).inertia_ratio(LAW) == pytest.approx(0.75 * slope.peak**2, rel=1e-4)


NO_EQUILIBRIUM = {
    "a constant drive": lambda v: (np.full(len(v), 5.0), 0 * v),
    "a drive of constant power": lambda v: (100 / v, -100 / v**2),
    "a drive that fades": lambda v: (100 * np.exp(-v / OMEGA), -100 / OMEGA * np.exp(-v / OMEGA)),
    "not a number": lambda v: (math.nan * v, math.nan * v),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("torque", NO_EQUILIBRIUM.values(), ids=NO_EQUILIBRIUM)
def test_a_torque_without_an_equilibrium_is_a_sentence(torque, method, points):
    points(64)
    with failed("no-convergence", "0.299"):
        getattr(shaft(0.3, torque), method)(LAW)


@settings(max_examples=10, deadline=None)
@given(st.floats(0.01, 100), st.floats(0.01, 100), st.floats(0.1, 10), st.sampled_from([None, motor_and_fan, line(100.0)]))
def test_units_of_mass_time_and_output_change_nothing(mass, time, stroke, torque):
    """All inertias and torques times mass, all speeds times time, torques with its square, the output times stroke."""
    scaled = torque and (lambda v: (mass * time**2 * torque(v / time)[0], mass * time * torque(v / time)[1]))
    law = FourierSeries(stroke * LAW.mean, stroke * LAW.cosine, stroke * LAW.sine)
    one = shaft(0.3, torque)
    other = CamShaft(mass * one.inertia, mass * one.output_inertia / stroke**2, time * one.mean_speed, scaled)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prediction, "_FEWEST", 64)
        patch.setattr(prediction, "_MOST", 64)
        for method in METHODS:
            expected = getattr(one, method)(LAW).speed(TAU)
            assert getattr(other, method)(law).speed(TAU) / time == pytest.approx(expected, rel=1e-10)
    assert other.inertia_ratio(law) == pytest.approx(one.inertia_ratio(LAW), rel=1e-12)


JS, FAST = 20.0, 500 * math.pi / 30
SHORT = FourierSeries.of(0.5, [-0.4, 0.1])


def predicted(torque: Torque | None = None) -> tuple[CamShaft, CorrectedLaw, ShaftMotion]:
    camshaft, law = CamShaft(JS, 6.0, FAST, torque), equiripple(5, math.radians(120), math.radians(24))
    motion = camshaft.motion_with_corrected_cam(law)
    return camshaft, CorrectedLaw(law, motion), motion


def test_a_simulation_shows_the_last_turn_and_the_deviation_in_all() -> None:
    """A shaft that begins off its steady speed: v = v0 + (v1 - v0) exp(-s t/JS), of an output without inertia."""
    v0, v1, s, turns = 60.0, 50.0, 40.0, 4
    camshaft = CamShaft(JS, 0.0, v0, lambda v: (s * (v0 - v), -s + 0 * v))
    made_of = confirmation(camshaft, SHORT, ShaftMotion(FourierSeries.of(v1)), turns, lambda share: None)
    period = 2 * math.pi / v1
    time = period * (turns - 1 + np.arange(2048) / 2048)
    v, phi = (v0 + (v1 - v0) * np.exp(-s * time / JS), v0 * time - (v0 - v1) * JS / s * (1 - np.exp(-s * time / JS)))
    expected = FourierSeries.from_samples(v)
    assert made_of.speed.mean == pytest.approx(expected.mean, rel=1e-10)
    assert made_of.speed.amplitudes == pytest.approx(expected.amplitudes, abs=1e-9)
    assert made_of.deviation == pytest.approx((v0 - v1) * (1 - math.exp(-s * period * turns / JS)) / v1, rel=1e-9)
    slope, bend = 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi), 0.4 * np.cos(phi) - 0.4 * np.cos(2 * phi)
    expected = FourierSeries.from_samples((bend * v**2 + slope * s * (v0 - v) / JS) / v1**2)
    assert made_of.acceleration.amplitudes[:20] == pytest.approx(expected.amplitudes[:20], rel=1e-8)


def test_a_simulation_that_would_not_end_is_given_up_and_says_so() -> None:
    """A torque that falls by 1e5 N m for each rad/s: a step must be shorter than its time constant."""
    stiff = lambda v: (1e5 * (FAST - v), np.full(np.shape(v), -1e5))  # noqa: E731
    found = confirmation(*predicted(stiff), 20, lambda share: None, most_calls=2500)
    assert math.isnan(found.deviation)
    assert found.failure.startswith("fails in turn 1 of 20: a turn takes more than 2500 evaluations")
    assert not confirmation(*predicted(), 1, lambda share: None, most_calls=2500).failure
