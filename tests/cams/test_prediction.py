"""The predicted speed: against closed forms, against integration in time, the balance of power, convergence, and its limits."""

import itertools
import math
import re
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import ellipe
from tests.refusals import failed, refused

from wucht.cams import prediction
from wucht.cams.correction import CorrectedLaw, MotionOverTime, Purity, orders, share_above_order
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.prediction import CamShaft, _newton, energy_balance, power_balance, unresolved_share
from wucht.errors import InputError, RunError
from wucht.numerics.fourier_series import FourierSeries, differentiation, even_angles

TURN = 2 * math.pi
LAW = equiripple(5, math.radians(120), math.radians(24))
FASTEST = float(np.abs(LAW(np.linspace(0, TURN, 20001), 1)).max())
SINE = FourierSeries.of(0.0, [], [1.0])  # psi'^2 = cos^2 phi
J0, OMEGA = 2.0, 50.0
TAU = even_angles(512)
METHODS = ["motion_with_cam", "motion_with_corrected_cam"]


@pytest.fixture
def points(monkeypatch):
    """Sets the number of collocation points: all that is tried, or the fewest and the most."""

    def chosen(fewest, most=None):
        monkeypatch.setattr(prediction, "_FEWEST", fewest)
        monkeypatch.setattr(prediction, "_MOST", most or fewest)

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


@pytest.mark.parametrize("kind", ["energy", "power"])
def test_the_jacobians_are_the_derivatives_of_what_is_off(kind):
    count, h = 32, 1e-5
    at, matrix = even_angles(count), differentiation(count)
    if kind == "energy":
        balance = partial(energy_balance, J0 + 0.5 * LAW(at, 1) ** 2, matrix, motor_and_fan)
        x = 2500 * (1 + 0.1 * np.cos(2 * at))
    else:
        balance = partial(power_balance, J0, 0.5 * LAW(at, 1) ** 2, matrix, motor_and_fan)
        x = OMEGA * (1 + 0.1 * np.cos(2 * at))
    step = h * x.max() * np.eye(count)
    found = np.array([(balance(x + d)[0] - balance(x - d)[0]) / (2 * h * x.max()) for d in step]).T
    assert balance(x)[1] == pytest.approx(found, abs=1e-8 * np.abs(found).max())


def test_eigenmotion_of_the_example_of_the_cases():
    """cases.md: J = 2 (1 + 0.3 cos 2 phi), E = 15300: T = 0.0505045348634485. It is 1.4 + 1.2 cos^2 phi: psi = sin phi."""
    period = 0.0505045348634485
    of = CamShaft(1.4, 1.2, TURN / period)
    found = of.motion_with_cam(SINE)
    assert kinetic_energy_of_the_original(of, SINE, found) == pytest.approx(np.full(512, 15300.0), rel=1e-12)
    phi = found.angle(TAU)
    assert found.speed(TAU) == pytest.approx(np.sqrt(15300.0 / (1 + 0.3 * np.cos(2 * phi))), rel=1e-12)


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


def test_eigenmotion_with_the_corrected_cam_ends_where_the_mean_of_a_root_says(points):
    """sqrt(kappa) times the mean of |sin|, 2/pi, must be below 1: kappa < pi^2/4 = 2.467. The original cam has no end."""
    points(64)
    slowest = [CamShaft(1.0, ratio, OMEGA).motion_with_corrected_cam(SINE).speed.bounds[0] for ratio in (2.3, 2.4, 2.46)]
    assert OMEGA / 4 > slowest[0] > slowest[1] > slowest[2] > 0
    beyond = CamShaft(1.0, 2.48, OMEGA)
    said = "without a torque the shaft would come to rest in each turn: the inertia ratio J1 max psi'^2/J0 is 2.48; without"
    with pytest.raises(RunError, match=re.escape(said) + r" a drive this law allows up to 2\.4\d; give a larger flywheel"):
        beyond.motion_with_corrected_cam(SINE)
    assert beyond.motion_with_cam(SINE).mean == pytest.approx(OMEGA)


@pytest.mark.parametrize(
    ("ratio", "torque"),
    [pytest.param(0.3, motor_and_fan, marks=pytest.mark.slow), (0.76, line(100.0))],
    ids=["motor and fan", "line"],
)
def test_with_a_torque_it_is_what_integration_over_time_settles_to(ratio, torque):
    of = shaft(ratio, torque)
    found = of.motion_with_cam(LAW)
    mean, phi, speed = settled(of, LAW, 12)
    assert found.mean == pytest.approx(mean, rel=1e-9)
    assert np.abs(found.speed(TAU) - speed).max() < 1e-8 * mean
    assert np.abs(found.angle(TAU) - phi).max() < 1e-8
    assert found.fluctuation > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "torque"),
    [(0.3, motor_and_fan), (0.76, line(100.0))],
    ids=["motor and fan", "line"],
)
def test_the_cam_corrected_beforehand_runs_clean_in_integration_over_time(ratio, torque):
    """The mean speed and the orders of the output come out of the integration, which knows the cam over its angle alone."""
    of = shaft(ratio, torque)
    found = of.motion_with_corrected_cam(LAW)
    law = CorrectedLaw(LAW, found)
    series = FourierSeries.from_samples(law(even_angles(2048))).without_rounding()  # the same, many times faster
    other = np.linspace(0, TURN, 77)
    assert series(other, 2) == pytest.approx(law(other, 2), abs=1e-9)
    mean, phi, speed = settled(of, series, 12)
    assert found.mean == pytest.approx(mean, rel=1e-9)
    assert np.abs(found.speed(TAU) - speed).max() < 1e-8 * mean
    output = FourierSeries.from_samples(series(phi)).amplitudes
    assert output[:5] == pytest.approx(orders(LAW, 0).amplitudes[:5], rel=1e-8)
    assert output[5:].max() < 1e-9 * output[0]
    assert FourierSeries.from_samples(LAW(phi)).amplitudes[5:].max() > 5e-3 * output[0]  # the original cam on that shaft


@pytest.mark.parametrize(
    "torque", [motor_and_fan, line(100.0), line(3000.0, 61.0)], ids=["motor and fan", "line", "stiff line"]
)
@pytest.mark.parametrize("method", METHODS)
def test_drive_and_load_do_no_work_over_a_turn(method, torque, points):
    points(128)
    found = getattr(shaft(0.5, torque), method)(LAW)
    speed = found.speed(TAU)
    power = torque(speed)[0] * speed
    assert abs(power.mean()) < 1e-9 * np.abs(power).max()
    assert np.abs(power).max() > 100


def test_the_mean_speed_follows_from_the_torque_and_not_from_what_was_expected(points):
    points(128)
    for method in METHODS:
        found = [getattr(shaft(0.3, motor_and_fan, expected), method)(LAW).speed(TAU) for expected in (45.0, 55.0, 62.0)]
        assert found[1] == pytest.approx(found[0], rel=1e-9)
        assert found[2] == pytest.approx(found[0], rel=1e-9)


def test_a_line_fixes_the_mean_over_angle_or_that_of_the_square_over_time(points):
    """The integral of T by phi is zero: with phi' dtau = dphi omega the mean over time of phi'^2 is free omega."""
    points(128)
    for method in METHODS:
        found = getattr(shaft(0.5, line(20.0, 41.0)), method)(LAW)
        assert (found.speed(TAU) ** 2).mean() == pytest.approx(41.0 * found.mean, rel=1e-11)
        assert found.mean < 40.9


def test_a_stiff_drive_turns_evenly_and_gives_the_power_that_the_output_takes(points):
    points(128, 2048)
    for method in METHODS:
        off = []
        for slope in (1e5, 1e6):
            of = shaft(0.5, line(slope))
            v = getattr(of, method)(LAW).speed(even_angles(2048))
            taken = of.power_at_constant_speed(LAW)
            off.append([np.abs(v - OMEGA).max(), np.abs(slope * (OMEGA - v) * OMEGA - taken).max() / taken.max()])
        (even, power), (evener, closer) = off
        assert evener < 1e-4 * OMEGA
        assert even / evener == pytest.approx(10, rel=0.05)
        assert closer < 1e-2
        assert power / closer == pytest.approx(10, rel=0.1)


def test_a_stiff_drive_is_found_where_the_eigenmotion_is_far_from_even(points):
    """Below a ratio of 1 there is a motion, as the sentence says, whatever the slope; beyond, a stiff drive still holds one."""
    points(128)
    for ratio, slope in ((0.97, 1e5), (1.2, 1e5), (1.6, 1e5)):
        found = shaft(ratio, line(slope)).motion_with_corrected_cam(LAW)
        assert found.mean == pytest.approx(OMEGA, rel=1e-4)
        assert 1e-3 < found.fluctuation < 1e-2


def test_a_weak_drive_beyond_the_threshold_holds_no_motion(points):
    points(128)
    said = "no periodic motion of the shaft was found: the inertia ratio J1 max psi'^2/J0 is 1.6; without a drive"
    with pytest.raises(RunError, match=re.escape(said)):
        shaft(1.6, line(1.0)).motion_with_corrected_cam(LAW)
    assert shaft(1.2, line(1.0)).motion_with_corrected_cam(LAW).fluctuation > 0.5


@pytest.mark.parametrize("method", METHODS)
def test_a_weak_drive_leaves_the_eigenmotion_and_ever_less_of_anything_else(method, points):
    """To first order in the slope."""
    points(128)
    off = []
    for slope in (2.0, 1.0, 0.5):
        found = getattr(shaft(0.5, line(slope)), method)(LAW)
        free = getattr(shaft(0.5, None, found.mean), method)(LAW)
        off.append(float(np.abs(found.speed(TAU) - free.speed(TAU)).max()))
    assert off[2] < 1e-3 * OMEGA
    assert [math.log2(off[0] / off[1]), math.log2(off[1] / off[2])] == pytest.approx([1, 1], abs=0.02)


@pytest.mark.parametrize("method", METHODS)
def test_an_output_without_inertia_leaves_an_even_speed(method):
    free = getattr(CamShaft(J0, 0.0, OMEGA), method)(LAW)
    driven = getattr(CamShaft(J0, 0.0, OMEGA, motor_and_fan), method)(LAW)
    assert free.speed(TAU) == pytest.approx(np.full(512, OMEGA), rel=1e-13)
    assert driven.fluctuation < 1e-12
    assert motor_and_fan(driven.mean)[0] == pytest.approx(0, abs=1e-9)
    assert 55 < driven.mean < 60


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


@pytest.mark.parametrize("torque", [pytest.param(None, marks=pytest.mark.slow), line(100.0)], ids=["eigenmotion", "line"])
def test_cutting_and_measuring_comes_to_the_cam_that_is_found_directly(torque, points):
    points(128)
    of = shaft(0.11, torque)
    direct = of.motion_with_corrected_cam(LAW)
    cam = CorrectedLaw(LAW, direct)
    again = of.motion_with_cam(cam)  # the cam is its own successor
    assert again.speed(TAU) == pytest.approx(direct.speed(TAU), rel=1e-11)
    assert share_above_order(orders(MotionOverTime(cam, again)), 5) < 1e-9
    speeds, cam = [], LAW
    for _ in range(4):
        measured = of.motion_with_cam(cam)
        speeds.append(float(np.abs(measured.speed(TAU) - direct.speed(TAU)).max()))
        cam = CorrectedLaw(LAW, measured)
    assert all(0.05 < after / before < 0.2 for before, after in itertools.pairwise(speeds))
    original, second = cut_and_measured(of, 2)
    assert original == pytest.approx(share_above_order(orders(MotionOverTime(LAW, of.motion_with_cam(LAW))), 5), rel=1e-12)
    assert second < original / 5
    left, motion = of.residual_with_cam(LAW, Purity.from_law(LAW, 5))
    assert left == original
    assert motion.speed(TAU) == pytest.approx(of.motion_with_cam(LAW).speed(TAU))


@pytest.mark.parametrize("torque", [None, motor_and_fan], ids=["eigenmotion", "motor and fan"])
@pytest.mark.parametrize("method", METHODS)
def test_errors_fall_faster_than_any_power_of_the_points(method, torque, points):
    of = shaft(0.3, torque)
    points(256)
    best = getattr(of, method)(LAW)
    errors = []
    for count in (32, 64, 128):
        points(count)
        errors.append(float(np.abs(getattr(of, method)(LAW).speed(TAU) - best.speed(TAU)).max()) / OMEGA)
    powers = [math.log2(errors[i] / errors[i + 1]) for i in range(2)]
    assert 4 < powers[0] < powers[1] - 4
    assert errors[2] < 1e-9


@pytest.mark.parametrize("method", METHODS)
def test_points_are_doubled_until_the_highest_orders_are_rounding_or_there_are_the_most(method, points):
    of = shaft(0.3, motor_and_fan)
    speeds = {}
    for fewest, most in ((16, 16), (16, 32), (16, 2048), (128, 128)):
        points(fewest, most)
        speeds[fewest, most] = getattr(of, method)(LAW).speed
    assert [speeds[16, most].count for most in (16, 32)] == [7, 15]
    assert 31 < speeds[16, 2048].count <= 127
    assert speeds[16, 2048](TAU) == pytest.approx(speeds[128, 128](TAU), rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_the_finer_solution_starts_from_the_coarser_one(method, points, monkeypatch):
    points(32, 512)
    sizes, solve = [], np.linalg.solve
    monkeypatch.setattr(np.linalg, "solve", lambda a, b: sizes.append(len(b)) or solve(a, b))
    rough = FourierSeries.from_samples(np.abs(np.sin(even_angles(4096))) ** 3)  # of a third derivative that jumps
    getattr(shaft(0.3, motor_and_fan), method)(rough)
    assert sizes.count(32) >= 3
    assert sizes.count(512) <= 2


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


NOT_POSITIVE = [0.0, -1.0, math.nan, math.inf]


@pytest.mark.parametrize("value", NOT_POSITIVE)
@pytest.mark.parametrize("name", ["inertia", "mean_speed"])
def test_inertia_and_mean_speed_must_be_positive(name, value):
    with refused(f"shaft.{name}", given=value, code="not-positive"):
        CamShaft(**{"inertia": J0, "output_inertia": 1.0, "mean_speed": OMEGA, name: value})


@pytest.mark.parametrize("value", [-1e-9, -1.0, math.nan, math.inf])
def test_the_inertia_of_the_output_must_not_be_negative(value):
    said = f"shaft.output_inertia: given {value!r}; must not be negative"
    with pytest.raises(InputError, match=re.escape(said)):
        CamShaft(J0, value, OMEGA)
    assert CamShaft(J0, 0.0, OMEGA).inertia_ratio(LAW) == 0


NO_EQUILIBRIUM = {
    "a constant drive": lambda v: (np.full(len(v), 5.0), 0 * v),
    "a constant brake": lambda v: (np.full(len(v), -5.0), 0 * v),
    "viscous friction": lambda v: (-v, np.full(len(v), -1.0)),
    "a drive of constant power": lambda v: (100 / v, -100 / v**2),
    "a drive that fades": lambda v: (100 * np.exp(-v / OMEGA), -100 / OMEGA * np.exp(-v / OMEGA)),
    "dry friction alone": lambda v: (-150 * np.tanh(v / 0.1), -1500 / np.cosh(np.minimum(v / 0.1, 300)) ** 2),
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


def test_a_balance_of_positive_unknowns() -> None:
    def square(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x**2 - 9.0, np.diag(2 * x)

    assert _newton(square, np.array([50.0]), lambda: "more") == pytest.approx([3.0], rel=1e-12)
    for balance in (
        lambda x: (x * 0 + 1.0, np.zeros((1, 1))),  # the same at all speeds
        lambda x: (x**2 + 1.0, np.diag(2 * x)),  # nowhere closed
    ):
        with pytest.raises(RunError) as raised:
            _newton(balance, np.array([1.0]), lambda: "take a larger flywheel")
        assert raised.value.code == "no-convergence" and ": take a larger flywheel, or a drive" in str(raised.value)


def test_unresolved_are_the_highest_quarter_of_the_orders():
    """Of 1024: from the 769th on; in shares of the mean speed."""
    for order, share in ((768, 0.0), (769, 1e-4), (1023, 1e-4)):
        cosine = np.zeros(1024)
        cosine[order - 1] = 5e-3
        assert unresolved_share(SimpleNamespace(speed=FourierSeries.of(50.0, cosine), mean=50.0)) == pytest.approx(share)
