"""The output on a spring: against textbook formulas, against integration in time, tuned levers, resonances over speed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.elastic_output import Dwell, ElasticOutput, largest_on_arc, truncate_law
from wucht.cams.elasticity import vibrations
from wucht.cams.laws.cam_segments import RiseAndReturn
from wucht.cams.laws.standard_laws import standard_law
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.motion_law import RiseMotionLaw
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi


def test_an_extremum_beside_an_end_is_found():
    """Between the first two samples, the first being the larger one."""
    assert largest_on_arc(-0.02, 2.0, np.zeros(1), np.ones((1, 1), complex)) == pytest.approx(1.0, abs=1e-15)


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
OUTPUT = ElasticOutput(0.05, 2000.0, 1.0)  # 200 rad/s, 5 %
SERIES = FourierSeries.of(0.1, [0.3, -0.1, 0.02], [0.05, 0.0, 0.04])


def same(a, b, tolerance):
    assert a.mean == pytest.approx(b.mean, abs=tolerance)
    assert a.cosine == pytest.approx(b.cosine, abs=tolerance)
    assert a.sine == pytest.approx(b.sine, abs=tolerance)


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


@pytest.mark.parametrize("output", [OUTPUT, ElasticOutput(0.05, 2000.0)])
@pytest.mark.parametrize("omega", [34.0, 150.0])
def test_with_a_tuned_lever_the_output_makes_the_law_exactly(output, omega):
    lever = output.tuned_lever(LAW, omega)
    same(output.steady(lever, omega), LAW, 1e-12)
    assert np.abs(lever(TAU) - LAW(TAU)).max() > 1e-3 * (omega / output.natural_frequency) ** 2
    assert output.residual(lever, omega, [DWELL])[0] == pytest.approx(RIPPLE, abs=1e-12)
    if not output.damping:
        ratio = np.arange(1, 6) * omega / output.natural_frequency
        assert lever.cosine == pytest.approx((1 - ratio**2) * LAW.cosine, abs=1e-14)


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


@pytest.mark.parametrize(("begin", "end"), [(-1.0, 1.0), (5.5, 0.7), (2.0, 2.0), (-7.0, -6.5)])
def test_the_largest_on_an_arc_is_that_of_a_fine_grid(begin, end):
    series = SERIES.shift(math.pi)  # least about 0
    arc = begin + np.linspace(0, end - begin + (TURN if end < begin else 0), 40001)
    found = Dwell(begin, end).largest(series)
    on_grid = np.abs(series(arc)).max()
    assert on_grid <= found + 1e-15
    assert found == pytest.approx(on_grid, abs=1e-8)


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


def test_behind_a_stiff_spring_each_cam_rests_in_its_dwell() -> None:
    """The original cam rests while the shaft turns through its dwell, which an uneven shaft reaches later than an even one."""
    rise = RiseAndReturn(standard_law("4-5-6-7"), 0.4, (math.pi / 2, math.pi), (math.pi, 3 * math.pi / 2))
    law = RiseMotionLaw(rise, "rad")
    uneven, dwell = ShaftMotion(FourierSeries.of(50.0, [5.0], [12.0])), Dwell(-math.pi / 2, math.pi / 2)
    stiff, speeds = ElasticOutput(6.0, 6.0 * 5e4**2), np.array([40.0, 50.0])
    springs = vibrations(stiff, law, uneven, uneven, (dwell,), speeds)
    assert springs.names[:2] == ("original cam", "corrected cam")
    assert springs.deviation[:2].max() < 2e-4 * 0.4
    assert max(e.deviation for e in springs.excitations) < 2e-4 * 0.4
    assert float(uneven.time(math.pi / 2)) < math.pi / 2 - 0.1, "the dwells differ"


def test_weights_of_orders_are_those_that_the_output_makes_of_them():
    omega = OUTPUT.natural_frequency / 3 * 1.01
    k = np.arange(1, 7)
    assert OUTPUT.weights(6, omega) == pytest.approx(k**2 * np.abs(OUTPUT.response(k * omega)))


def test_what_makes_no_sense_is_refused():
    for ask, key in (
        (lambda: ElasticOutput(0.0, 1.0), "output.inertia"), (lambda: ElasticOutput(1.0, math.inf), "output.stiffness"),
        (lambda: ElasticOutput(1.0, 1.0, -0.1), "output.damping"), (lambda: OUTPUT.steady(LAW, 0.0), "omega"),
        (lambda: OUTPUT.tuned_lever(LAW, 10.0, 1.0), "most"), (lambda: Dwell(0.0, 7.0), "dwell"),
        (lambda: Dwell(0.0, 1.0, math.nan), "dwell.value"), (lambda: OUTPUT.residual(LAW, 10.0, []), "dwells"),
        (lambda: OUTPUT.residual_over_speed(LAW, np.zeros(0), [DWELL]), "speeds"),
        (lambda: truncate_law(LAW, 50, 100), "orders"),
    ):  # fmt: skip
        with pytest.raises(InputError) as raised:
            ask()
        assert raised.value.location == key
