"""The output on a spring: against textbook formulas, against integration in time, tuned levers, resonances over speed."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.refusals import refused

from wucht.cams.elastic_output import Dwell, ElasticOutput, largest_on_arc, ranked_excitations, truncate_law
from wucht.cams.laws.standard_laws import STANDARD_LAWS, RiseAndReturn
from wucht.cams.laws.synthesis import Band, equiripple, synthesise
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi


@pytest.mark.parametrize(("begin", "arc"), [(0.0, TURN), (-2.0, 4.0), (1.0, 0.05), (3.0, 0.0)])
@pytest.mark.parametrize("orders", [0, 1, 12])
def test_it_is_that_of_a_fine_grid(begin, arc, orders):
    random = np.random.default_rng(7)
    mean, waves = random.normal(size=70), random.normal(size=(70, orders)) + 1j * random.normal(size=(70, orders))
    found = largest_on_arc(begin, arc, mean, waves)
    x = begin + np.linspace(0, arc, 20001)
    on_grid = np.abs(mean[:, None] + (waves @ np.exp(1j * np.outer(np.arange(1, orders + 1), x))).real).max(axis=1)
    assert (found >= on_grid * (1 - 1e-12)).all()
    assert found == pytest.approx(on_grid, rel=1e-5)


def test_an_extremum_beside_an_end_is_found():
    """Between the first two samples, the first being the larger one."""
    assert largest_on_arc(-0.02, 2.0, np.zeros(1), np.ones((1, 1), complex)) == pytest.approx(1.0, abs=1e-15)


def test_it_is_that_at_the_stationary_points():
    series = FourierSeries.of(0.3, [1.0, -0.2, 0.0, 0.4], [0.0, 0.7, 0.1])
    assert Dwell(0.0, TURN).largest(series) == pytest.approx(series.peak, rel=1e-15)


def test_many_speeds_at_once_are_each_alone():
    output, lever = ElasticOutput(0.05, 2000.0, 0.05), FourierSeries.of(0.0, [1.0, 0.2, 0.05], [0.0, 0.1])
    dwells, speeds = [Dwell(-0.5, 0.5, 1.2), Dwell(2.0, 2.5)], np.linspace(20.0, 90.0, 7)
    swept = output.residual_over_speed(lever, speeds, dwells)
    alone = [output.residual(lever, float(w), dwells) for w in speeds]
    assert np.transpose(swept) == pytest.approx(np.array(alone), rel=1e-14)


TAU = np.linspace(0, TURN, 20001)
HALF = math.radians(110)  # of the dwell about 0
DWELL = Dwell(-HALF, HALF)
LAW = equiripple(5, HALF, 0.4)
RIPPLE = DWELL.largest(LAW)
POLYNOMIAL = RiseAndReturn(STANDARD_LAWS["3-4-5"], 0.4, (HALF, math.pi))
OUTPUT = ElasticOutput(0.05, 2000.0, 1.0)  # 200 rad/s, 5 %
SERIES = FourierSeries.of(0.1, [0.3, -0.1, 0.02], [0.05, 0.0, 0.04])


def settled(output, lever, omega, turns, at):
    """psi_o at tau = at in [0, 2 pi], integrated over so many turns before that turn."""

    def slope(tau, y):
        lag, rate = lever(tau) - y[0], lever(tau, 1) - y[1]
        return y[1], (output.damping * omega * rate + output.stiffness * lag) / (output.inertia * omega**2)

    begin = [float(lever(0.0)), float(lever(0.0, 1))]
    run = solve_ivp(slope, (0, (turns + 1) * TURN), begin, "DOP853", t_eval=turns * TURN + at, rtol=1e-12, atol=1e-13)
    return run.y[0]


def same(a, b, tolerance):
    assert a.mean == pytest.approx(b.mean, abs=tolerance)
    assert a.cosine == pytest.approx(b.cosine, abs=tolerance)
    assert a.sine == pytest.approx(b.sine, abs=tolerance)


def test_natural_frequency_and_damping_ratio():
    assert OUTPUT.natural_frequency == pytest.approx(200)
    assert OUTPUT.damping_ratio == pytest.approx(0.05)


@pytest.mark.parametrize("ratio", [0.1, 0.9, 1.0, math.sqrt(2), 3.0])
def test_one_order_is_passed_on_as_the_textbook_says(ratio):
    """Transmissibility and phase of a mass moved through spring and damper; at sqrt(2) it is 1 with any damping."""
    k, z = 3, OUTPUT.damping_ratio
    omega = ratio * OUTPUT.natural_frequency / k
    out = OUTPUT.steady(FourierSeries.of(0.0, [0, 0, 1.0]), omega)
    expected = math.sqrt((1 + (2 * z * ratio) ** 2) / ((1 - ratio**2) ** 2 + (2 * z * ratio) ** 2))
    phase = math.atan2(2 * z * ratio, 1) - math.atan2(2 * z * ratio, 1 - ratio**2)
    assert out(TAU) == pytest.approx(expected * np.cos(k * TAU + phase), abs=1e-11)
    assert abs(OUTPUT.response(k * omega)) == pytest.approx(expected)
    if ratio == math.sqrt(2):
        assert expected == pytest.approx(1)


def test_the_steady_motion_satisfies_its_equation():
    omega = 70.0
    out = OUTPUT.steady(SERIES, omega)
    force = OUTPUT.damping * omega * (out(TAU, 1) - SERIES(TAU, 1)) + OUTPUT.stiffness * (out(TAU) - SERIES(TAU))
    assert OUTPUT.inertia * omega**2 * out(TAU, 2) + force == pytest.approx(np.zeros(len(TAU)), abs=1e-9)
    same(OUTPUT.elastic_part(SERIES, omega), FourierSeries(0.0, out.cosine - SERIES.cosine, out.sine - SERIES.sine), 1e-14)


def test_the_elastic_part_of_a_stiff_output_keeps_its_digits():
    """To first order in omega^2/omega_0^2 it is -psi_l'' of that: the widening of the acceleration in 004, figure 4."""
    stiff, omega = ElasticOutput(0.05, 2e12), 30.0
    expected = -(omega**2) * 0.05 / 2e12 * SERIES(TAU, 2)
    assert stiff.elastic_part(SERIES, omega)(TAU) == pytest.approx(expected, rel=1e-8, abs=1e-18)


@pytest.mark.slow
def test_the_steady_motion_is_what_integration_settles_to():
    out = OUTPUT.steady(SERIES, 61.0)
    at = np.linspace(0, TURN, 50)
    assert np.abs(settled(OUTPUT, SERIES, 61.0, 35, at) - out(at)).max() < 1e-9


@pytest.mark.slow
def test_a_truncated_polynomial_law_differs_from_its_integration_by_what_is_left_out():
    omega, at = 23.0, np.linspace(0, TURN, 200)
    true = settled(OUTPUT, POLYNOMIAL, omega, 7, at)
    off, left = [], []
    for count in (15, 30, 60):
        found = truncate_law(POLYNOMIAL, count)
        off.append(np.abs(OUTPUT.steady(found, omega)(at) - true).max())
        assert count * omega > math.sqrt(2) * OUTPUT.natural_frequency
        left.append(np.abs(found(TAU) - POLYNOMIAL(TAU)).max())
        assert off[-1] < left[-1]  # no order above grows on its way to the output
    assert left[0] > 6 * left[1] > 36 * left[2]  # orders go down as 1/k^4: their sum as 1/k^3
    assert off[0] > 10 * off[1] > 100 * off[2]  # and |H| at least as 1/k


@pytest.mark.parametrize("output", [OUTPUT, ElasticOutput(0.05, 2000.0), ElasticOutput(0.05, 2000.0, 20.0)])
@pytest.mark.parametrize("omega", [5.0, 34.0, 46.0, 150.0])
def test_with_a_tuned_lever_the_output_makes_the_law_exactly(output, omega):
    lever = output.tuned_lever(LAW, omega)
    same(output.steady(lever, omega), LAW, 1e-12)
    assert np.abs(lever(TAU) - LAW(TAU)).max() > 1e-3 * (omega / output.natural_frequency) ** 2
    assert output.residual(lever, omega, [DWELL])[0] == pytest.approx(RIPPLE, abs=1e-12)
    if not output.damping:
        ratio = np.arange(1, 6) * omega / output.natural_frequency
        assert lever.cosine == pytest.approx((1 - ratio**2) * LAW.cosine, abs=1e-14)


def test_a_tuned_lever_is_for_one_speed():
    """It excites less than the plain one about its own speed, and more far below it."""
    tuned = OUTPUT.tuned_lever(LAW, 30.0)
    speeds = np.linspace(1.0, 33.0, 33)
    of_tuned, plain = (OUTPUT.residual_over_speed(lever, speeds, [DWELL])[0] for lever in (tuned, LAW))
    assert np.argmin(of_tuned) == 29
    assert of_tuned[29] == pytest.approx(RIPPLE, abs=1e-12)
    assert (of_tuned[26:] < 0.5 * plain[26:]).all()
    assert (of_tuned[:15] > plain[:15]).all()


def test_over_speed_the_residual_is_largest_where_an_order_meets_the_natural_frequency():
    output = ElasticOutput(0.05, 2000.0, 0.05)
    speeds = np.linspace(30.0, 220.0, 1901)
    deviation, _ = output.residual_over_speed(LAW, speeds, [DWELL])
    orders, resonances = output.resonances(LAW, 30.0, 220.0)
    assert orders.tolist() == [1, 2, 3, 4, 5]
    assert resonances == pytest.approx(200 / np.arange(1, 6))
    inner = deviation[1:-1]
    peaks = speeds[1:-1][(inner > deviation[:-2]) & (inner > deviation[2:]) & (inner > 0.1)]
    assert peaks == pytest.approx(resonances[::-1], abs=0.11)
    assert output.resonances(LAW, 60.0, 70.0)[0].tolist() == [3]


def test_a_finite_series_has_no_resonance_below_that_of_its_last_order_and_a_polynomial_has():
    output = ElasticOutput(0.05, 2000.0, 0.05)
    speeds = np.linspace(14.0, 36.0, 111)
    deviation, _ = output.residual_over_speed(LAW, speeds, [DWELL])
    assert len(output.resonances(LAW, 14.0, 36.0)[0]) == 0
    assert (np.diff(deviation) > 0).all()
    polynomial = truncate_law(POLYNOMIAL, 40)
    _, acceleration = output.residual_over_speed(polynomial, speeds, [DWELL])
    assert output.resonances(polynomial, 14.0, 36.0)[0].tolist() == list(range(6, 15))
    inner = acceleration[1:-1]
    peaks = speeds[1:-1][(inner > acceleration[:-2]) & (inner > acceleration[2:])]
    assert max(np.abs(peaks - r).min() for r in 200 / np.arange(6, 11)) < 0.21


def test_a_stiffer_output_leaves_only_what_the_lever_does_in_the_dwell():
    """The deviation goes down to the ripple of the lever as 1/c."""
    above = [ElasticOutput(0.05, c).residual(LAW, 20.0, [DWELL])[0] - RIPPLE for c in (1e6, 1e7, 1e8)]
    assert above[0] > 0
    assert above[0] / above[1] == pytest.approx(10, rel=0.01)
    assert above[1] / above[2] == pytest.approx(10, rel=0.01)


def test_units_do_not_matter():
    deviation, acceleration = OUTPUT.residual(LAW, 31.0, [DWELL])
    heavier = ElasticOutput(0.05e3, 2e6, 1e3).residual(LAW, 31.0, [DWELL])
    assert heavier == pytest.approx((deviation, acceleration), rel=1e-12)
    quicker = ElasticOutput(0.05, 2000.0 * 60**2, 60.0).residual(LAW, 31.0 * 60, [DWELL])
    assert quicker == pytest.approx((deviation, 3600 * acceleration), rel=1e-12)
    degrees = FourierSeries(0.0, np.degrees(LAW.cosine), np.degrees(LAW.sine))
    centred, _ = OUTPUT.residual(degrees, 31.0, [Dwell(-HALF, HALF, -math.degrees(LAW.mean))])
    assert centred == pytest.approx(math.degrees(deviation), rel=1e-12)


@pytest.mark.parametrize(("begin", "end"), [(-1.0, 1.0), (5.5, 0.7), (2.0, 2.0), (0.0, TURN), (1.0, 1.3), (-7.0, -6.5)])
def test_the_largest_on_an_arc_is_that_of_a_fine_grid(begin, end):
    series = SERIES.shift(math.pi)  # least about 0
    arc = begin + np.linspace(0, end - begin + (TURN if end < begin else 0), 40001)
    found = Dwell(begin, end).largest(series)
    on_grid = np.abs(series(arc)).max()
    assert on_grid <= found + 1e-15
    assert found == pytest.approx(on_grid, abs=1e-8)


def test_two_dwells_count_as_the_worse_one():
    bottom, top = Dwell(-0.5, 0.5), Dwell(math.pi - 0.2, math.pi + 0.2, 0.4)
    single = [OUTPUT.residual(LAW, 25.0, [d]) for d in (bottom, top)]
    both = OUTPUT.residual(LAW, 25.0, [bottom, top])
    assert both == tuple(map(max, zip(*single, strict=True)))
    assert single[0][0] < single[1][0]


def test_the_corrected_cam_excites_less_than_the_original_one_and_the_polynomial_more():
    """004, section 3: on an uneven shaft the original cam has orders above those of its law, here near the resonance."""
    ahead = FourierSeries.of(0.0, [0, 0.01, -0.005], [0, 0.02, 0.01])

    def original(tau, order=0):
        assert order == 0
        return LAW(tau + ahead(tau))

    # The dwell of the original cam over tau, such that its angle stays within the dwell of the law.
    ends = [float(np.interp(a, TAU - math.pi + ahead(TAU - math.pi), TAU - math.pi)) for a in (-HALF, HALF)]
    levers = {
        "3-4-5": (truncate_law(POLYNOMIAL, 60), (DWELL,)),
        "original": (truncate_law(original, 30), (Dwell(*ends),)),
        "corrected": (LAW, (DWELL,)),
        "tuned": (OUTPUT.tuned_lever(LAW, 28.5), (DWELL,)),
    }
    found = ranked_excitations(OUTPUT, levers, 28.5)  # order 7 in resonance
    assert [e.name for e in found] == ["tuned", "corrected", "original", "3-4-5"]
    assert found[0].peak == pytest.approx(28.5**2 * LAW.derivative(2).peak, rel=1e-12)
    for e in found:
        lever, dwells = levers[e.name]
        out = OUTPUT.steady(lever, 28.5)
        assert e.peak == pytest.approx(28.5**2 * np.abs(out(TAU, 2)).max(), rel=1e-6)
        assert (e.deviation, e.acceleration) == OUTPUT.residual(lever, 28.5, dwells)


def test_weights_from_a_resonance_give_the_law_with_the_least_acceleration_of_the_output():
    omega = OUTPUT.natural_frequency / 3 * 1.01
    restrictions = [Band("stroke", 0, math.pi, math.pi, 0.4, 0.4), Band("dwell", 0, -0.8, 0.8, -0.01, 0.01)]
    count, k = 6, np.arange(1, 7)
    weights = OUTPUT.weights(count, omega)
    assert weights == pytest.approx(k**2 * np.abs(OUTPUT.response(k * omega)))
    assert OUTPUT.weights(count, omega, 0.0) == pytest.approx(weights / k**2)
    aware, blind = (synthesise(count, restrictions, w).law for w in (weights, k**2))
    of_output = [np.hypot.reduce(OUTPUT.steady(law, omega).derivative(2).amplitudes) for law in (aware, blind)]
    of_lever = [np.hypot.reduce(law.derivative(2).amplitudes) for law in (aware, blind)]
    assert of_output[0] < 0.7 * of_output[1]
    assert of_lever[0] > of_lever[1]
    assert aware.amplitudes[2] < 0.2 * blind.amplitudes[2]


@pytest.mark.parametrize(
    ("values", "refusal"),
    [
        ((0.0, 1.0, 0.0), refused("output.inertia", given=0.0, code="not-positive")),
        ((math.nan, 1.0, 0.0), refused("output.inertia", given=float("nan"), code="not-positive")),
        ((1.0, -1.0, 0.0), refused("output.stiffness", given=-1.0, code="not-positive")),
        ((1.0, math.inf, 0.0), refused("output.stiffness", given=float("inf"), code="not-positive")),
        ((1.0, 1.0, -0.1), refused("output.damping", given=-0.1, code="negative")),
    ],
)
def test_an_impossible_output_is_refused(values, refusal):
    with refusal:
        ElasticOutput(*values)


@pytest.mark.parametrize("omega", [0.0, -3.0, math.nan, math.inf])
def test_a_speed_that_is_not_positive_is_refused(omega):
    for ask in (OUTPUT.steady, OUTPUT.elastic_part, OUTPUT.tuned_lever):
        with refused("omega", "rad/s", given=omega, code="not-positive"):
            ask(LAW, omega)
    with refused("omega", "rad/s", given=omega, code="not-positive"):
        OUTPUT.weights(3, omega)


def test_an_undamped_output_at_resonance_has_no_steady_motion_but_for_levers_without_that_order():
    undamped = ElasticOutput(0.05, 2000.0)
    omega = undamped.natural_frequency / 3
    with refused("omega", "order 3", given=omega, code="resonance"):
        undamped.steady(LAW, omega)
    with refused("omega", "order 3", given=omega, code="resonance"):
        undamped.weights(3, omega)
    assert np.isinf(undamped.response(200.0))
    without = FourierSeries.of(0.0, [1.0, 0.5, 0.0, 0.2])
    assert undamped.steady(without, omega).amplitudes == pytest.approx([9 / 8, 0.5 * 9 / 5, 0, 0.2 * 9 / 7])


@pytest.mark.parametrize(
    ("omega", "refusal"),
    [
        (50.0, refused("law", "order 4", code="near-resonance")),
        (49.0, refused("law", "order 4", code="near-resonance")),
        (250.0, refused("law", "order 4", "5 times", code="above-resonance")),
    ],
)
def test_a_lever_is_not_tuned_to_an_order_that_makes_it_unreasonable(omega, refusal):
    undamped = ElasticOutput(0.05, 2000.0)
    with refusal:
        undamped.tuned_lever(LAW, omega)
    if omega != 50.0:
        same(undamped.steady(undamped.tuned_lever(LAW, omega, math.inf), omega), LAW, 1e-12)
    else:
        odd = ElasticOutput(0.07, 1900.0)
        assert 0 < abs(1 / odd.response(odd.natural_frequency / 3 * 3 * (1 + 1e-15))) < 1e-12  # but for rounding
        with refused("law", "order 3", code="near-resonance"):
            odd.tuned_lever(LAW, odd.natural_frequency / 3 * (1 + 1e-15), math.inf)


def test_other_input_that_makes_no_sense_is_refused():
    with refused("most", given=1.0):
        OUTPUT.tuned_lever(LAW, 10.0, 1.0)
    with refused("dwell", given=[0.0, 7.0]):
        Dwell(0.0, 7.0)
    with refused("dwell.value", given=float("nan")):
        Dwell(0.0, 1.0, math.nan)
    with refused("dwells", given=None):
        OUTPUT.residual(LAW, 10.0, [])
    with refused("speeds", given=None):
        OUTPUT.residual_over_speed(LAW, np.zeros(0), [DWELL])
    with refused("orders", given=50):
        truncate_law(POLYNOMIAL, 50, 100)
    with refused("a law without a dwell: dwells", given=None):
        ranked_excitations(OUTPUT, {"a law without a dwell": (LAW, ())}, 10.0)


@pytest.mark.parametrize("stiffness", [2000.0, 1 / 2000])
def test_a_resonance_is_met_if_it_is_nearer_than_a_millionth_of_a_millionth(stiffness):
    """Of the stiffness of the spring, whether that is large or small: less than rounding can tell."""
    output, lever = ElasticOutput(stiffness, stiffness, 0.0), FourierSeries.of(0.0, [1.0])
    for off, met in ((0.5e-12, True), (2e-12, False)):
        omega = math.sqrt(1 + off)
        if met:
            with refused("omega", "order 1", given=omega, code="resonance"):
                output.steady(lever, omega)
        else:
            assert abs(output.steady(lever, omega).cosine[0]) > 1e11
