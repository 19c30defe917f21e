"""Linkages between lever and output: closure, both directions, dead points, and laws seen through them."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.refusals import refused

from wucht.cams.linkages.closure import LeverMotion, composed_derivative
from wucht.cams.linkages.four_bar_and_slider_crank import FourBar, SliderCrank
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries

PI = math.pi
PHI = np.linspace(0, 2 * PI, 41)
ROCKERS = FourBar(0.1, 0.08, 0.07, 0.08, 1.2)
CRANK_ROCKER = FourBar(0.1, 0.04, 0.12, 0.09, 1.0)
DOUBLE_CRANK = FourBar(0.04, 0.1, 0.09, 0.12, 1.0)
PARALLELOGRAM = FourBar(0.1, 0.05, 0.1, 0.05, 1.0)
SLIDER = SliderCrank(0.05, 0.2, 1.0, offset=0.01)
ROCKING_SLIDER = SliderCrank(0.2, 0.05, 0.1, offset=-0.01, branch=-1)
CROSSED = FourBar(0.1, 0.08, 0.07, 0.08, 1.2, branch=-1)
LINKAGES = [ROCKERS, CRANK_ROCKER, DOUBLE_CRANK, PARALLELOGRAM, SLIDER, ROCKING_SLIDER, CROSSED]
every_linkage = pytest.mark.parametrize(
    "linkage", LINKAGES, ids=["rockers", "crank-rocker", "double-crank", "parallelogram", "slider", "rocking-slider", "crossed"]
)


def inner(limits, count=31, share=0.9):
    """Values within limits, not near the dead points; over three turns where there are none."""
    low, high = (x if math.isfinite(x) else math.copysign(10.0, x) for x in limits)
    return (low + high) / 2 + (high - low) / 2 * share * np.linspace(-1, 1, count)


def differences(function, x, h):
    """The first derivative, of sixth order in h."""
    return sum(c / 60 * (function(x + k * h) - function(x - k * h)) for k, c in ((1, 45), (2, -9), (3, 1))) / h


def norton(g, a, b, c, alpha, branch):
    """A vector at half the output's angle, from Freudenstein's equation (R. L. Norton, Design of Machinery, chapter 4)."""
    K1, K2, K3 = g / a, g / c, (a**2 - b**2 + c**2 + g**2) / (2 * a * c)
    A = np.cos(alpha) - K1 - K2 * np.cos(alpha) + K3
    B = -2 * np.sin(alpha)
    C = K1 - (K2 + 1) * np.cos(alpha) + K3
    return 2 * A + 1j * (-B - branch * np.sqrt(B**2 - 4 * A * C))


lengths = st.floats(0.2, 2.0)
angles = st.floats(-PI, PI)
branches = st.sampled_from([-1, 1])
shares = st.floats(-0.95, 0.95)


@st.composite
def four_bars(draw):
    """Four-bars that close, not near a dead point."""
    g, a, c, angle, branch = draw(lengths), draw(lengths), draw(lengths), draw(angles), draw(branches)
    to_joint = abs(a * np.exp(1j * angle) - g)
    assume(to_joint > 0.05)
    least, most = abs(to_joint - c), to_joint + c
    return made(FourBar, g, a, least + (most - least) * draw(st.floats(0.05, 0.95)), c, angle, branch)


@st.composite
def slider_cranks(draw):
    a, angle, offset, branch = draw(lengths), draw(angles), draw(st.floats(-1, 1)), draw(branches)
    least = abs(offset - a * math.sin(angle))
    return made(SliderCrank, a, least + draw(st.floats(0.1, 3)), angle, offset, branch)


def made(cls, *parameters):
    try:
        return cls(*parameters)
    except InputError:
        assume(False)


@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("linkage", [ROCKERS, CRANK_ROCKER, DOUBLE_CRANK])
def test_freudenstein(linkage, branch):
    """On both branches as Norton defines them."""
    g, a, b, c, angle = linkage.ground, linkage.input, linkage.coupler, linkage.output, linkage.angle
    linkage = FourBar(g, a, b, c, angle, branch)
    rho = inner(linkage.lever_limits)
    turned = (norton(g, a, b, c, angle + rho, branch) / norton(g, a, b, c, angle, branch)) ** 2
    assert np.exp(1j * linkage.output_at(rho)) == pytest.approx(turned / np.abs(turned), abs=1e-12)


@settings(max_examples=150, deadline=None)
@given(st.one_of(four_bars(), slider_cranks()), shares)
def test_there_and_back(linkage, share):
    """psi -> rho -> psi, and the derivatives of that. An error of rho comes back larger by as much as the output is faster."""
    low, high = inner(linkage.output_limits, 2, 1.0)
    psi = (low + high) / 2 + share * (high - low) / 2
    forth = linkage.lever_derivatives(psi)
    back = linkage.output_derivatives(forth[0])
    assert back[0] == pytest.approx(psi, abs=1e-12 * max(1, abs(back[1])))
    for order in (1, 2, 3):
        terms = composed_derivative(np.abs(back), np.abs(forth[: order + 1]))
        assert composed_derivative(back, forth[: order + 1]) == pytest.approx(float(order == 1), abs=1e-9 * max(1, terms))


@settings(max_examples=100, deadline=None)
@given(four_bars(), shares)
def test_the_coupler_keeps_its_length(linkage, share):
    """From the output's angle, which the reference position and psi give, and the lever's."""
    low, high = inner(linkage.output_limits, 2, 1.0)
    psi = (low + high) / 2 + share * (high - low) / 2
    g, a, b, c, angle = linkage.ground, linkage.input, linkage.coupler, linkage.output, linkage.angle
    half = norton(g, a, b, c, angle, linkage.branch)
    assume(abs(half) > 0.01)  # else Norton's formula loses its digits
    beta = 2 * np.angle(half) + psi
    rod = g + c * np.exp(1j * beta) - a * np.exp(1j * (angle + linkage.lever_at(psi)))
    assert abs(rod) == pytest.approx(b, abs=1e-11)


@settings(max_examples=200, deadline=None)
@given(four_bars())
def test_grashof(linkage):
    """The lever turns round if shortest plus longest are less than the others and it, or the ground, is shortest."""
    g, a, b, c = linkage.ground, linkage.input, linkage.coupler, linkage.output
    excess = min(g, a, b, c) + max(g, a, b, c) - (g + a + b + c) / 2
    assume(abs(excess) > 1e-6)
    turns = excess < 0
    assert (linkage.lever_limits == (-math.inf, math.inf)) == (turns and min(g, a, b, c) in (a, g))
    assert (linkage.output_limits == (-math.inf, math.inf)) == (turns and min(g, a, b, c) == g)


@every_linkage
@pytest.mark.parametrize("order", [0, 1, 2])
def test_derivatives(linkage, order):
    """Dead points are 160 steps or more away; of the rounding (1e-13 near a dead point) 1/h remains."""
    for function, limits in ((linkage.lever_at, linkage.output_limits), (linkage.output_at, linkage.lever_limits)):
        x = inner(limits)
        h = min(1e-3, (x[1] - x[0]) / 100)
        rounding = 3e-13 * max(np.abs(function(x, n)).max() for n in range(order + 2)) / h
        truncation = 1e-10 * np.abs(function(x, order + 1)).max()
        expected = differences(lambda at, f=function: f(at, order), x, h)
        assert function(x, order + 1) == pytest.approx(expected, abs=rounding + truncation)


def test_limits_of_a_crank_rocker():
    """The output swings as far as the law of cosines says, with crank and coupler in line; the crank turns round."""
    g, a, b, c = 0.1, 0.04, 0.12, 0.09
    far, near = (math.acos((g**2 + c**2 - r**2) / (2 * g * c)) for r in (b + a, b - a))
    start = 2 * np.angle(norton(g, a, b, c, 1.0, 1)) % (2 * PI)
    assert CRANK_ROCKER.output_limits == pytest.approx((PI - far - start, PI - near - start), abs=1e-12)
    assert CRANK_ROCKER.lever_limits == (-math.inf, math.inf)
    psi = CRANK_ROCKER.output_at(np.linspace(0, 2 * PI, 5001))
    assert (psi.min(), psi.max()) == pytest.approx(CRANK_ROCKER.output_limits, abs=1e-6)


def test_transmission_angle():
    """Of a four-bar by the law of cosines, of a slider-crank from the slope of the rod."""
    rho = inner(ROCKERS.lever_limits)
    diagonal = np.abs(0.08 * np.exp(1j * (1.2 + rho)) - 0.1)
    between = np.arccos((0.07**2 + 0.08**2 - diagonal**2) / (2 * 0.07 * 0.08))
    assert ROCKERS.transmission_angle(rho) == pytest.approx(np.minimum(between, PI - between), abs=1e-12)
    slope = np.arcsin((0.01 - 0.05 * np.sin(1.0 + PHI)) / 0.2)
    assert SLIDER.transmission_angle(PHI) == pytest.approx(PI / 2 - np.abs(slope), abs=1e-12)
    law = FourierSeries.of(0.0, [0.1])
    motion = LeverMotion(law, ROCKERS)
    assert motion.transmission_angle(PHI) == pytest.approx(ROCKERS.transmission_angle(ROCKERS.lever_at(law(PHI))))


def test_a_dead_point_between_samples_is_seen():
    """The law goes from 0 to a limit half a step of the grid of 2048 from it; on the grid it is less by 6e-7 of that."""
    for limit in ROCKERS.output_limits:
        law = FourierSeries.of(limit / 2, [limit / 2]).shift(PI / 2048)
        assert abs(law(np.arange(2048) * PI / 1024)).max() < (1 - 5e-7) * abs(limit)
        for share, passes in ((1 - 1e-7, True), (1 + 1e-7, False)):
            scaled = FourierSeries(share * law.mean, share * law.cosine, share * law.sine)
            if passes:
                LeverMotion(scaled, ROCKERS)
                continue
            with refused("linkage", "output"):
                LeverMotion(scaled, ROCKERS)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        (lambda: FourBar(0.0, 1, 1, 1, 1), "linkage.ground: given 0.0; must be a length greater than 0 m"),
        (lambda: FourBar(1, 1, 1, 1, 1, 0), "linkage.branch: given 0; must be +1 (open) or -1 (crossed)"),
        (
            lambda: FourBar(4, 3, 7.5, 2, PI / 2),
            "linkage.coupler: given 7.5; must be between 3000 mm and 7000 mm, not 7500 mm, to close the linkage",
        ),
        (
            lambda: FourBar(4, 3, 7, 2, PI / 2),
            "linkage.angle: given '90 deg'; must not be a dead point: the rod cannot move the output",
        ),
        (
            lambda: FourBar(5, 1, 2, 4, math.acos(0.6)),
            "linkage.angle: given '53.1301 deg'; must not be a dead point: the rod is in line with the lever",
        ),
        (
            lambda: SliderCrank(1, 1.5, PI / 2, -0.5),
            "linkage.angle: given '90 deg'; must not be a dead point: the rod cannot move the output",
        ),
        (
            lambda: LeverMotion(FourierSeries.of(0.3, [1.2]), CRANK_ROCKER),
            "linkage: given '-51.5662 deg'; the output must stay between -5.03629 deg and 60.1296 deg, where the linkage",
        ),
    ],
)
def test_wrong_linkages(wrong, sentence):
    with pytest.raises(InputError) as error:
        wrong()
    assert sentence in str(error.value)
