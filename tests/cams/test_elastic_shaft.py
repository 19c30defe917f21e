"""The shaft that twists: against a formula, against integration in time, the balance of energy, convergence, and its limits."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.refusals import failed, refused

from wucht.cams import elastic_shaft
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
def test_it_converges_faster_than_any_power_of_the_number_of_points(cam):
    load = cam(LAW, J)
    true = SHAFT.periodic_motion(load, DRIVE, OMEGA, 192).fluctuation(TAU)
    found = {n: SHAFT.periodic_motion(load, DRIVE, OMEGA, n) for n in (16, 32, 64, 128)}
    off = {n: np.abs(t.fluctuation(TAU) - true).max() for n, t in found.items()}
    order = [math.log2(off[n] / off[2 * n]) for n in (16, 32, 64)]
    assert order[0] < order[1] < order[2]
    assert order[2] > 10
    assert off[128] < 1e-9
    residuals = [t.residual for t in found.values()]
    assert residuals == sorted(residuals, reverse=True)
    assert residuals[0] > 0.1
    assert residuals[-1] < 1e-4
    assert max(t.iterations for t in found.values()) <= 6


@pytest.mark.parametrize("cam", CAMS)
def test_a_stiff_shaft_turns_as_its_flywheel(cam):
    off = []
    for c in (1e6, 1e7, 1e8):
        found = ElasticShaft(0.02, c, 0.1).periodic_motion(cam(LAW, J), DRIVE, OMEGA)
        off.append(np.abs(found.fluctuation(TAU) - DRIVE(TAU)).max())
    assert off[0] < 1e-4
    assert off[0] / off[1] == pytest.approx(10, rel=1e-2)
    assert off[1] / off[2] == pytest.approx(10, rel=1e-2)


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


def test_the_output_is_the_law_over_the_angle_or_over_time():
    original, corrected = (SHAFT.periodic_motion(cam(LAW, J), DRIVE, OMEGA, 160) for cam in CAMS)
    assert original.output(TAU) == pytest.approx(LAW(original.angle(TAU)), abs=1e-12)
    assert corrected.output(TAU) == pytest.approx(LAW(TAU), abs=1e-12)
    assert original.output.amplitudes[5] > 1e-3
    assert corrected.output.amplitudes[5:].max() < 1e-14


class CutFor:
    """The law over its angle of the cam that is corrected for a motion of its shaft."""

    def __init__(self, law, turning):
        self.law, self.ahead = law, turning.fluctuation

    def __call__(self, phi, order=0):
        tau = np.asarray(phi, float)
        for _ in range(30):
            tau = tau - (tau + self.ahead(tau) - phi) / (1 + self.ahead(tau, 1))
        v, a, j = 1 + self.ahead(tau, 1), self.ahead(tau, 2), self.ahead(tau, 3)
        P, Q, R = (self.law(tau, n) for n in (1, 2, 3))
        p = P / v
        q = (Q - p * a) / v**2
        return [self.law(tau), p, q, (R - 3 * q * v * a - p * j) / v**3][order]


def test_a_corrected_cam_turns_as_that_cam_with_the_law_it_is_cut_with():
    corrected = SHAFT.periodic_motion(CorrectedCam(LAW, J), DRIVE, OMEGA)
    cut = SHAFT.periodic_motion(OriginalCam(CutFor(LAW, corrected), J), DRIVE, OMEGA)
    assert np.abs(cut.fluctuation(TAU) - corrected.fluctuation(TAU)).max() < 1e-8
    assert np.abs(cut.output(TAU) - LAW(TAU)).max() < 1e-8


@pytest.mark.parametrize("cam", CAMS)
def test_the_derivatives_of_the_torque_are_those_of_differences(cam):
    load, h = cam(LAW, J), 1e-6
    tau = TAU[::40]
    state = [tau + DRIVE(tau), 1 + DRIVE(tau, 1), DRIVE(tau, 2)]
    exact = load.torque(tau, *state)
    for i in range(3):
        below, above = ([s + (sign * h if k == i else 0) for k, s in enumerate(state)] for sign in (-1, 1))
        difference = (load.torque(tau, *above)[0] - load.torque(tau, *below)[0]) / (2 * h)
        assert exact[i + 1] == pytest.approx(difference, abs=1e-9)
    assert np.abs(exact[2]).max() > 1e-3


@pytest.mark.parametrize("cam", CAMS)
def test_units_and_time_do_not_matter(cam):
    base = SHAFT.periodic_motion(cam(LAW, J), DRIVE, OMEGA)
    heavy = ElasticShaft(20.0, 200e3, 400.0).periodic_motion(cam(LAW, 1e3 * J), DRIVE, OMEGA)
    quick = ElasticShaft(0.02, 200.0 * 49, 0.4 * 7).periodic_motion(cam(LAW, J), DRIVE, OMEGA * 7)
    for found, torque, speed in ((heavy, 1e3, 1), (quick, 49, 7)):
        assert np.abs(found.fluctuation(TAU) - base.fluctuation(TAU)).max() < 1e-12
        assert found.torque(TAU) == pytest.approx(torque * base.torque(TAU), abs=1e-9 * torque)
        assert found.residual == pytest.approx(torque * base.residual, rel=1e-3)
        assert found.speed(TAU) == pytest.approx(speed * base.speed(TAU), rel=1e-12)


def test_a_heavy_output_on_a_light_cam_needs_more_steps_and_is_found():
    light = ElasticShaft(0.02, 50.0, 0.1)
    found = light.periodic_motion(CorrectedCam(LAW, 0.12), FourierSeries.of(0.0), OMEGA)
    assert found.iterations > 4
    assert found.residual < 0.01
    assert found.speed.bounds[0] < 0.5 * OMEGA


def test_where_the_cam_would_turn_back_it_says_so():
    with failed("stands-still", "20 rad/s"):
        ElasticShaft(0.02, 700.0, 0.1).periodic_motion(OriginalCam(LAW, 0.2), DRIVE, OMEGA)


def test_where_no_motion_is_found_it_says_how_far_it_came():
    with failed("no-convergence", "N", "m"):
        ElasticShaft(0.02, 300.0, 0.1).periodic_motion(CorrectedCam(LAW, 0.2), DRIVE, OMEGA)


def test_an_undamped_shaft_in_resonance_says_so():
    with failed("resonance", "3"):
        ElasticShaft(0.02, 0.02 * (3 * OMEGA) ** 2).periodic_motion(OriginalCam(LAW, 0.0), DRIVE, OMEGA)


@pytest.mark.parametrize(
    ("values", "refusal"),
    [
        ((0.0, 1.0, 0.0), refused("shaft.inertia", given=0.0, code="not-positive")),
        ((1.0, 0.0, 0.0), refused("shaft.stiffness", given=0.0, code="not-positive")),
        ((1.0, math.nan, 0.0), refused("shaft.stiffness", given=float("nan"), code="not-positive")),
        ((1.0, 1.0, -1e-9), refused("shaft.damping", given=-1e-09, code="negative")),
    ],
)
def test_an_impossible_shaft_is_refused(values, refusal):
    with refusal:
        ElasticShaft(*values)


@pytest.mark.parametrize("cam", CAMS)
def test_an_output_of_negative_inertia_is_refused(cam):
    with refused("load.inertia", given=-0.1, code="negative"):
        cam(LAW, -0.1)


def test_other_input_that_makes_no_sense_is_refused():
    load = OriginalCam(LAW, J)
    for omega in (0.0, -1.0, math.nan):
        with refused("omega"):
            SHAFT.periodic_motion(load, DRIVE, omega)
    for points in (63, 6, 2):
        with refused("points"):
            SHAFT.periodic_motion(load, DRIVE, OMEGA, points)
    with refused("drive", given=None):
        SHAFT.periodic_motion(load, FourierSeries.of(0.0, [0.0, 0.6]), OMEGA)


def test_newtons_method_has_as_many_steps_as_it_is_given(monkeypatch):
    load = CorrectedCam(LAW, J)
    needed = SHAFT.periodic_motion(load, DRIVE, OMEGA, 32).iterations
    monkeypatch.setattr(elastic_shaft, "_MOST_STEPS", needed)
    assert SHAFT.periodic_motion(load, DRIVE, OMEGA, 32).iterations == needed
    monkeypatch.setattr(elastic_shaft, "_MOST_STEPS", needed - 1)
    with failed("no-convergence"):
        SHAFT.periodic_motion(load, DRIVE, OMEGA, 32)


def test_a_flywheel_may_be_fast_for_a_while_if_it_never_stands_still():
    """phi_d' = 1 + 0.9 cos tau + 0.3 cos 2 tau: from 0.36 to 2.2. With the other sign it would turn back."""
    uneven, mirrored = (FourierSeries.of(0.0, [], [sign * 0.9, sign * 0.15]) for sign in (1, -1))
    found = ElasticShaft(1e-3, 1e6).periodic_motion(OriginalCam(LAW, 0.0), uneven, OMEGA)
    assert found.speed.bounds == pytest.approx(np.array(uneven.derivative().bounds) * OMEGA + OMEGA, rel=1e-3)
    with refused("drive", given=None):
        SHAFT.periodic_motion(OriginalCam(LAW, 0.0), mirrored, OMEGA)
