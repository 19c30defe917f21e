"""The corrected cam: 004, its claims, and what is left where the shaft turns otherwise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import jv
from tests.refusals import refused

from wucht.cams.correction import (
    CorrectedLaw,
    MotionOverTime,
    Purity,
    best_delay,
    explained_share,
    orders,
    orders_beside,
    residual_of_extra_order,
    residuals,
    share_above_order,
)
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.measured_acceleration import MeasuredAcceleration
from wucht.cams.shaft_motion import ShaftMotion
from wucht.measurements.recording import Channel
from wucht.numerics.fourier_series import FourierSeries

OMEGA = 500 * math.pi / 30
LAW = equiripple(5, math.radians(120), math.radians(24))
PHI = np.linspace(0, 2 * math.pi, 400)


def shaft(scale=1.0):
    return ShaftMotion(
        FourierSeries.of(OMEGA, scale * np.array([0, 2.4, 1, 0.5, 0.3]), scale * np.array([0, 1, -1.3, 0.2, 0.4]))
    )


def test_orders_of_a_cosine_on_a_shaft_with_one_order_are_bessel_functions():
    """cases.md: psi = cos phi, phi = omega t + 0.05 sin 2 omega t has orders 1, 3, 5 of 0.974382909, 0.025304623, 0.000309831.

    cos(x + z sin 2 x) = sum J_n(z) cos((1 + 2 n) x).
    """
    of = ShaftMotion(FourierSeries.of(1.0, [0.0, 0.1]))
    found = orders(MotionOverTime(FourierSeries.of(0.0, [1.0]), of), 0)
    assert found.amplitudes[[0, 2, 4]] == pytest.approx([0.974382909, 0.025304623, 0.000309831], abs=5e-10)
    z = 0.05
    bessel = [jv(0, z) + jv(-1, z), jv(1, z) + jv(-2, z), jv(2, z) + jv(-3, z)]
    assert found.cosine[[0, 2, 4]] == pytest.approx(bessel, abs=1e-14)


@pytest.mark.parametrize("kind", [CorrectedLaw, MotionOverTime])
def test_derivatives_are_those_of_the_motion(kind):
    of, h = kind(LAW, shaft()), 1e-4
    for order in (1, 2, 3):
        lower = (of(PHI + h, order - 1) - of(PHI - h, order - 1)) / (2 * h)
        assert of(PHI, order) == pytest.approx(lower, abs=2e-5 * np.abs(lower).max())


def test_what_is_left_where_the_shaft_turns_otherwise():
    """To first order what is left is proportional to what is wrong: five degrees leave five times as much as one."""
    found = residuals(LAW, 5, shaft())
    assert found.pop("as measured") < 1e-13
    one, five = (found.pop(f"the phase of the speed, or the cam on its shaft, off by {d}°") for d in (1, 5))
    assert five == pytest.approx(5 * one, rel=0.05)
    less, more = found.pop("90 % of the fluctuation"), found.pop("110 % of the fluctuation")
    assert more == pytest.approx(less, rel=0.05)
    even = found.pop("a shaft that turns evenly")
    assert even == pytest.approx(10 * more, rel=0.1)
    assert found.pop("a mean speed off by 10 %, the fluctuation the same in rad/s") > 1.05 * more
    assert set(found) == {f"order {j} left out of the correction" for j in (2, 3, 4, 5)}  # order 1 is none here
    assert max(found, key=found.get) == "order 2 left out of the correction"


@pytest.mark.parametrize("degrees", [1, -1, 5, -5])
def test_a_phase_that_is_off_either_way_leaves_no_more_than_is_said(degrees):
    said = residuals(LAW, 5, shaft())
    one = said[f"the phase of the speed, or the cam on its shaft, off by {abs(degrees)}°"]
    both = [
        share_above_order(orders(MotionOverTime(CorrectedLaw(LAW, shaft(), math.radians(d)), shaft())), 5)
        for d in (degrees, -degrees)
    ]
    assert one == max(both)
    assert abs(both[0] - both[1]) > 1e-4 * one


def test_what_an_order_leaves_that_nobody_corrects_for():
    """As much as if it were known and left out, to the worst of its phases."""
    whole = shaft()
    known = residuals(LAW, 5, whole)
    for j in (2, 3, 4, 5):
        more = residual_of_extra_order(LAW, 5, whole.without_order(j), j, float(whole.speed.amplitudes[j - 1]))
        assert 0.9 < more / known[f"order {j} left out of the correction"] < 1.3
    beyond = residual_of_extra_order(LAW, 5, whole, 9, 0.5)  # an order above those of the speed
    assert 0.01 < beyond == pytest.approx(residual_of_extra_order(LAW, 5, whole, 9, 0.25) * 2, rel=0.05)
    assert residual_of_extra_order(LAW, 5, whole, 2, 1e-9) < 1e-8, "beside what the speed has of that order already"
    with refused("speed", given=None):
        residual_of_extra_order(LAW, 5, whole, 1, OMEGA)


@pytest.mark.parametrize("degrees", [5.0, -40.0, 0.0])
def test_the_delay_of_a_measured_acceleration(degrees):
    of = shaft()
    found = orders(MotionOverTime(LAW, of))
    measured = FourierSeries(7.0, OMEGA**2 * found.cosine[:15], OMEGA**2 * found.sine[:15]).shift(math.radians(degrees))
    computed = orders_beside(measured, LAW, of)
    delay, share = best_delay(measured, computed)
    assert math.degrees(delay) == pytest.approx(degrees, abs=1e-6)
    assert share == pytest.approx(1.0, abs=1e-12)
    assert explained_share(measured, computed) <= share + 1e-12
    twice = FourierSeries(7.0, 2 * measured.cosine, 2 * measured.sine)
    late, share = best_delay(twice, orders_beside(twice, LAW, of))
    assert math.degrees(late) == pytest.approx(degrees, abs=1e-6)
    assert share == pytest.approx(0.75, abs=1e-12), "half of each amplitude is left, a quarter of the mean square"


def harmonics(*amplitudes):
    """Orders 1, 2 and so on, as cosines and sines by turns."""
    a = np.array(amplitudes, float)
    odd = np.arange(len(a)) % 2 == 0
    return FourierSeries(0.0, np.where(odd, a, 0.0), np.where(odd, 0.0, -a))


def test_a_share_is_of_the_first_order_or_of_another():
    acceleration = harmonics(2.0, 5.0, 0.4, 0.1, 0.3)
    assert share_above_order(acceleration, 2) == pytest.approx(0.2)
    assert share_above_order(acceleration, 3) == pytest.approx(0.15)
    assert share_above_order(acceleration, 2, 2) == pytest.approx(0.08)
    assert share_above_order(acceleration, 5) == 0.0


def test_a_law_of_few_orders_is_measured_above_its_last_by_its_lowest():
    """Orders 2 and 3 of the motion: the reference is order 2, and N is 3; accelerations are j^2 times as large."""
    purity = Purity.from_law(FourierSeries.of(0.4, [0.0, 0.3, 0.0], [0.0, 0.0, 0.1]))
    assert (purity.count, purity.reference) == (3, 2)
    assert purity.target.amplitudes[[1, 2]] == pytest.approx([4 * 0.3, 9 * 0.1])
    assert purity.share(harmonics(9.0, 2.0, 7.0, 0.5, 0.1)) == pytest.approx(0.25)
    assert Purity.from_law(FourierSeries.of(0.0, [0.3, 0.2]), 1).share(harmonics(2.0, 0.5)) == pytest.approx(0.25)
    with refused("law", given=None):
        Purity.from_law(FourierSeries.of(1.0, [0.0]))


def test_a_law_without_an_end_is_measured_by_the_largest_deviation():
    """A kink of the motion: orders beyond 256."""
    law = StandardLaw()
    purity = Purity.from_law(law)
    assert purity.count is None
    assert purity.share(purity.target) == 0.0
    cosine, sine = purity.target.cosine.copy(), purity.target.sine.copy()
    cosine[4] += 0.3
    sine[4] -= 0.4
    first = float(np.hypot(cosine[0], sine[0]))
    assert purity.share(FourierSeries(0.0, cosine[:9], sine[:9])) == pytest.approx(0.5 / first)


class StandardLaw:
    """An acceleration that jumps: 1 on a quarter of a turn, else a constant that makes its mean zero."""

    def __call__(self, phi, order=0):
        assert order == 2
        return np.where(np.mod(phi, 2 * np.pi) < np.pi / 2, 1.0, -1 / 3)


def measured(
    delay: float = 0.0,
    amplitude: float = 1.0,
    noise: float = 0.0,
    above: tuple[float, ...] = (1.0, 0.0),
    channel: Channel | None = None,
    turns: float = 5.0,
) -> MeasuredAcceleration:
    """A record of cos(tau - delay) about 100, of which amplitude cos(tau) is computed."""
    record = FourierSeries.of(100.0, [math.cos(delay)], [math.sin(delay)])
    some = Channel("record", "a", "m/s^2", np.arange(2.0), np.arange(2.0)) if channel is None else channel
    return MeasuredAcceleration(some, record, FourierSeries.of(0.0, [amplitude]), noise, turns, 1.0, 0.25, np.array(above))


def test_a_delay_counts_where_it_explains_noticeably_more() -> None:
    """Of the mean square the delay costs 2 (1 - cos delay): half a percent."""
    enough, less = (math.acos(1 - gain / 2) for gain in (0.00505, 0.00495))
    assert measured(enough).delay == (pytest.approx(enough, abs=1e-6), pytest.approx(1.0))
    assert measured(-enough).delay == (pytest.approx(-enough, abs=1e-6), pytest.approx(1.0))
    assert measured(less).delay is None


def test_a_delay_counts_where_it_explains_most_of_the_record() -> None:
    """An amplitude c explains 2 c - c^2 of the orders, whose power of one half stands beside that of the noise."""
    assert measured(0.5, 1 - math.sqrt(0.495)).delay is not None and measured(0.5, 1 - math.sqrt(0.505)).delay is None
    assert measured(0.5, noise=math.sqrt(0.49)).delay is not None and measured(0.5, noise=math.sqrt(0.51)).delay is None
    assert measured(noise=math.sqrt(0.5)).share_of_record(0.8) == pytest.approx(0.4)


def test_a_record_without_orders_is_no_acceleration():
    for mean in (0.0, -9.81):
        with refused("acceleration", code="constant"):
            orders_beside(FourierSeries(mean, np.full(15, 1e-14 * mean), np.zeros(15)), LAW, shaft())
    with refused("acceleration", code="no-orders"):
        orders_beside(FourierSeries.of(1.0), LAW, shaft())
