"""The shaft that twists: against a formula, against integration in time, the balance of energy, convergence, and its limits."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.refusals import failed, refused

from wucht.cams.elastic_shaft import CorrectedCam, ElasticShaft, OriginalCam
from wucht.cams.laws.synthesis import equiripple
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
TAU = TURN * np.arange(2000) / 2000
LAW = equiripple(5, math.radians(110), 0.4)
DRIVE = FourierSeries.of(0.02, [0.03, 0.01, -0.005], [0.01, 0.02, 0.0])
SHAFT = ElasticShaft(0.02, 200.0, 0.4)
OMEGA, J = 20.0, 0.02
CAMS = [OriginalCam, CorrectedCam]


def settled(cam, turns, at):
    """phi - tau and phi' at tau = at in [0, 2 pi], integrated from the motion of the flywheel so many turns before."""

    def slope(tau, y):
        phi, v = y
        pull = SHAFT.damping / OMEGA * (v - 1 - DRIVE(tau, 1)) + SHAFT.stiffness / OMEGA**2 * (phi - tau - DRIVE(tau))
        if cam is OriginalCam:
            p, q = LAW(phi, 1), LAW(phi, 2)
            return v, -(pull + J * p * q * v**2) / (SHAFT.inertia + J * p**2)
        return v, -(pull + J * LAW(tau, 1) * LAW(tau, 2) / v) / SHAFT.inertia

    begin = [float(DRIVE(0.0)), 1 + float(DRIVE(0.0, 1))]
    at = turns * TURN + at
    run = solve_ivp(slope, (0, (turns + 1) * TURN), begin, "DOP853", t_eval=at, rtol=1e-11, atol=1e-12)
    return run.y[0] - at, run.y[1]


@pytest.mark.parametrize("cam", [pytest.param(OriginalCam, marks=pytest.mark.slow), CorrectedCam])
def test_it_is_what_integration_settles_to(cam):
    at = np.linspace(0, TURN, 100)
    found = SHAFT.periodic_motion(cam(LAW, J), DRIVE, OMEGA, 192)
    ahead, speed = settled(cam, 7, at)
    assert np.abs(found.fluctuation(at) - ahead).max() < 1e-8
    assert np.abs(found.speed(at) / OMEGA - speed).max() < 1e-8
    assert np.abs(found.fluctuation(at) - DRIVE(at)).max() > 0.02  # the shaft twists


def test_without_an_output_each_order_is_passed_on_as_the_textbook_says():
    for cam in CAMS:
        found = SHAFT.periodic_motion(cam(LAW, 0.0), DRIVE, OMEGA)
        w = OMEGA * np.arange(1, 4)
        passed = SHAFT.stiffness + 1j * w * SHAFT.damping
        expected = (DRIVE.cosine - 1j * DRIVE.sine) * passed / (passed - SHAFT.inertia * w**2)
        assert found.fluctuation.mean == pytest.approx(DRIVE.mean)
        assert found.fluctuation.cosine[:3] - 1j * found.fluctuation.sine[:3] == pytest.approx(expected, abs=1e-13)
        assert found.fluctuation.amplitudes[3:].max() < 1e-13
        assert found.iterations == 2  # it is linear


@pytest.mark.parametrize("cam", CAMS)
def test_over_a_turn_the_flywheel_gives_what_the_damper_takes(cam):
    found = SHAFT.periodic_motion(cam(LAW, J), DRIVE, OMEGA, 160)
    speed, of_flywheel = found.speed(TAU), OMEGA * (1 + DRIVE(TAU, 1))
    to_cam, given = np.mean(found.torque(TAU) * speed), np.mean(found.torque(TAU) * of_flywheel)
    lost = np.mean(SHAFT.damping * (of_flywheel - speed) ** 2)
    assert lost > 0.5
    assert given == pytest.approx(lost, rel=1e-7)
    assert to_cam == pytest.approx(0, abs=1e-7 * lost)


@pytest.mark.parametrize("cam", CAMS)
def test_at_any_time_the_shaft_gives_what_cam_and_output_store(cam):
    """From tau = 0: the work of the torque against the kinetic energy."""
    found = SHAFT.periodic_motion(cam(LAW, J), DRIVE, OMEGA, 160)
    power = FourierSeries.from_samples(found.torque(TAU) * found.speed(TAU) / OMEGA)
    k = np.arange(1, power.count + 1)
    work = FourierSeries(0.0, -power.sine / k, power.cosine / k)
    stored = (SHAFT.inertia * found.speed(TAU) ** 2 + J * (OMEGA * found.output(TAU, 1)) ** 2) / 2
    assert np.ptp(stored) > 1
    assert work(TAU) - work(0.0) == pytest.approx(stored - stored[0], abs=1e-8)


def test_where_the_cam_would_turn_back_it_says_so():
    with failed("stands-still", "20 rad/s"):
        ElasticShaft(0.02, 700.0, 0.1).periodic_motion(OriginalCam(LAW, 0.2), DRIVE, OMEGA)


def test_where_no_motion_is_found_it_says_how_far_it_came():
    with failed("no-convergence", "N", "m"):
        ElasticShaft(0.02, 300.0, 0.1).periodic_motion(CorrectedCam(LAW, 0.2), DRIVE, OMEGA)


def test_an_undamped_shaft_in_resonance_says_so():
    with failed("resonance", "3"):
        ElasticShaft(0.02, 0.02 * (3 * OMEGA) ** 2).periodic_motion(OriginalCam(LAW, 0.0), DRIVE, OMEGA)


def test_a_flywheel_may_be_fast_for_a_while_if_it_never_stands_still():
    """phi_d' = 1 + 0.9 cos tau + 0.3 cos 2 tau: from 0.36 to 2.2. With the other sign it would turn back."""
    uneven, mirrored = (FourierSeries.of(0.0, [], [sign * 0.9, sign * 0.15]) for sign in (1, -1))
    found = ElasticShaft(1e-3, 1e6).periodic_motion(OriginalCam(LAW, 0.0), uneven, OMEGA)
    assert found.speed.bounds == pytest.approx(np.array(uneven.derivative().bounds) * OMEGA + OMEGA, rel=1e-3)
    with refused("drive", given=None):
        SHAFT.periodic_motion(OriginalCam(LAW, 0.0), mirrored, OMEGA)


def test_a_speed_and_points_that_are_none_are_refused():
    for omega, points, key in ((0.0, 64, "omega"), (math.nan, 64, "omega"), (OMEGA, 63, "points"), (OMEGA, 6, "points")):
        with refused(key):
            SHAFT.periodic_motion(OriginalCam(LAW, J), DRIVE, omega, points)
