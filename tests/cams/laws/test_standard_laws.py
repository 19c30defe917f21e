"""Standard motion laws: the printed characteristic numbers, rest at the ends, and the motion over a turn of the cam."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from wucht.cams.laws.cam_segments import RiseAndReturn
from wucht.cams.laws.standard_laws import SPLINES, STANDARD_LAWS, sine_constant_cosine, spline, standard_law
from wucht.errors import InputError

PI = math.pi
DEG = PI / 180
POINTS = ((0.3, 0.2), (0.55, 0.6), (0.8, 0.75))
ALL = {**STANDARD_LAWS, **{name: standard_law(name, POINTS) for name in SPLINES}}
every_law = pytest.mark.parametrize("law", ALL.values(), ids=list(ALL))


def inside(law, count=41):
    """Places in all pieces, none at a knot."""
    return np.concatenate(
        [a + (b - a) * np.linspace(0.01, 0.99, count) for a, b in zip(law.knots, law.knots[1:], strict=False)]
    )


@pytest.mark.parametrize(
    ("kind", "printed", "closed"),
    [
        ("3-4-5", (1.875, 5.7735, 60), (15 / 8, 10 / math.sqrt(3), 60)),
        ("4-5-6-7", (2.1875, 7.5132, 52.5), (35 / 16, 84 / 5 / math.sqrt(5), 52.5)),
        ("inclined-sine", (2, 6.2832, 39.478), (2, 2 * PI, 4 * PI**2)),
        ("modified-sine", (1.7596, 5.5280, 69.466), (4 * PI / (4 + PI), 4 * PI**2 / (4 + PI), 16 * PI**3 / (4 + PI))),
        ("modified-trapezoid", (2, 4.8881, 61.426), (2, 8 * PI / (2 + PI), 32 * PI**2 / (2 + PI))),
        ("harmonic", (1.5708, 4.9348, 15.503), (PI / 2, PI**2 / 2, PI**3 / 2)),
        ("parabolic", (2, 4, 0), (2, 4, 0)),
    ],
)
def test_characteristic_numbers(kind, printed, closed):
    """All digits of cases.md, and the closed forms to rounding."""
    law = STANDARD_LAWS[kind]
    numbers = (law.Cv, law.Ca, law.Cj)
    assert [float(f"{n:.5g}") for n in numbers] == list(printed)
    assert numbers == pytest.approx(closed, rel=1e-14)


@every_law
@pytest.mark.parametrize("order", [1, 2, 3])
def test_nothing_is_larger_than_the_largest(law, order):
    x = np.linspace(0, 1, 20001)
    on_grid = np.abs([law(x, order, side=side) for side in ("left", "right")]).max()
    assert on_grid <= law.largest(order) * (1 + 1e-13)
    assert on_grid == pytest.approx(law.largest(order), rel=1e-3)  # by the distance of the samples from the peak


@every_law
@pytest.mark.parametrize("order", [0, 1, 2])
def test_derivatives_are_those_of_the_formula(law, order):
    """Differences of sixth order over h: rounding 1e-16/h, truncation h^6 times the ninth derivative, at most 1e6."""
    x, h = inside(law), 1e-3 * np.diff(law.knots).min()
    steps = sum(c / 60 * (law(x + k * h, order) - law(x - k * h, order)) for k, c in ((1, 45), (2, -9), (3, 1)))
    assert law(x, order + 1) == pytest.approx(steps / h, abs=2e-9 * law.largest(order + 1))


@pytest.mark.parametrize("shares", [(0.2, 0.5, 0.3), (0.25, 0.5, 0.25), (0.4, 0.6, 0), (0, 0.5, 0.5), (0, 1, 0), (1, 0, 0)])
def test_sine_constant_cosine(shares):
    """Its acceleration by Norton's five zones, integrated by quadrature; (0, 1, 0) is the constant acceleration of Ca = 4."""
    b, c, d = shares
    law = sine_constant_cosine(b, c, d)
    assert law(1.0) == pytest.approx(1, abs=1e-14)
    assert law.Ca == pytest.approx(law(b / 2 + c / 4, 2, side="left"), rel=1e-14)
    assert law.Cv == pytest.approx(law(0.5, 1), rel=1e-14)

    def acceleration(x):
        if x > 0.5:
            return -acceleration(1 - x)
        if x < b / 2:
            return law.Ca * math.sin(PI * x / b)
        return law.Ca if x < (1 - d) / 2 else law.Ca * math.cos(PI / d * (x - (1 - d) / 2))

    for x in (0.07, 0.31, 0.48, 0.66, 0.93):
        assert law(x, 2) == pytest.approx(acceleration(x), abs=1e-13)
        breaks = [k for k in law.knots[1:-1] if k < x] or None
        assert law(x, 1) == pytest.approx(quad(acceleration, 0, x, points=breaks)[0], abs=1e-12)
    if not b + d:
        assert (law.Cv, law.Ca, law.Cj) == (2, 4, 0)


@pytest.mark.parametrize(("name", "degree"), SPLINES.items())
def test_splines_pass_their_points(name, degree):
    law = standard_law(name, POINTS)
    x, s = np.transpose(POINTS)
    assert law(x) == pytest.approx(s, abs=1e-14)
    for order in range(degree):  # all derivatives below the degree are continuous
        assert law(x, order, side="left") == pytest.approx(law(x, order), rel=1e-9, abs=1e-9)
    assert np.abs(law(x, degree, side="left") - law(x, degree)).min() > 1
    with_ends = standard_law(name, [(0, 0), *POINTS, (1, 1)])
    assert np.array_equal(with_ends.polynomials, law.polynomials)
    resting = law(np.array([0.0, 1.0]), 2)
    assert (np.abs(resting).max() < 1e-12) == (degree == 5)


@pytest.mark.parametrize(
    ("kind", "points", "sentence"),
    [
        ("3-4-6", (), "law.kind: given '3-4-6'; unknown kind; did you mean '3-4-5'? known: 3-4-5, 4-5-6-7, cubic-spline, "),
        ("3-4-5", POINTS, "law.points: only a spline goes through points, not the law '3-4-5'"),
        ("cubic-spline", [(0.5, math.nan)], "law.points: given [[0.5, nan]]; must be pairs of finite numbers: "),
        ("quintic-spline", [(0.5, 0.5), (0.5, 0.6)], "the shares of the arc must increase, from 0 to 1"),
    ],
)
def test_wrong_laws(kind, points, sentence):
    with pytest.raises(InputError) as error:
        standard_law(kind, points)
    assert sentence in str(error.value)


LAW = STANDARD_LAWS["modified-sine"]


def test_rise_dwell_return_dwell():
    stroke, rise, back = 0.3, (50 * DEG, 110 * DEG), (200 * DEG, 290 * DEG)
    motion = RiseAndReturn(LAW, stroke, rise, back)
    x = np.linspace(0, 1, 11)[:-1]
    up, down = rise[0] + 60 * DEG * x, back[0] + 90 * DEG * x
    for order in range(4):
        assert motion(up, order) == pytest.approx(stroke * LAW(x, order) / (60 * DEG) ** order, rel=1e-12, abs=1e-12)
        returning = stroke * LAW(1 - x, order, side="left") / (-90 * DEG) ** order
        assert motion(down, order) == pytest.approx(returning, rel=1e-12, abs=1e-12)
        resting = np.array([110, 150, 199.999, 290, 359, 0, 49.999, 405]) * DEG
        assert np.array_equal(motion(resting, order), np.where(np.arange(8) < 3, stroke, 0) * (order == 0))
        peak = np.abs(motion(np.linspace(0, 2 * PI, 50001), order)).max()
        assert peak == pytest.approx(motion.largest(order) if order else stroke, rel=1e-3)
    assert motion.largest(2) == pytest.approx(stroke * LAW.Ca / (60 * DEG) ** 2)
    assert RiseAndReturn(LAW, -stroke, back, rise).largest(1) == pytest.approx(stroke * LAW.Cv / (60 * DEG))


@pytest.mark.parametrize("turns", [-3, 0, 1, 2])
def test_where_a_derivative_jumps_it_is_that_of_what_begins(turns):
    law, length = STANDARD_LAWS["3-4-5"], 70 * DEG
    motion = RiseAndReturn(law, 1.0, (30 * DEG, 100 * DEG), (170 * DEG, 240 * DEG))
    jerk = motion(np.array([30, 100, 170, 240]) * DEG + 2 * PI * turns, 3) * length**3
    assert jerk == pytest.approx([60, 0, -60, 0], abs=1e-8)
    cubic, arc = spline(POINTS, 3), 100 * DEG
    motion = RiseAndReturn(cubic, 1.0, (0, arc))
    knots = np.array([k for k, _ in POINTS])
    rising, returning = motion(arc * knots + 2 * PI * turns, 3), motion(-arc * knots + 2 * PI * turns, 3)
    assert rising * arc**3 == pytest.approx(cubic(knots, 3), rel=1e-12)
    assert -returning * arc**3 == pytest.approx(cubic(knots, 3, side="left"), rel=1e-12)


@pytest.mark.parametrize("rise", [(300, 400), (300, 40), (-60, 40), (660, 40 + 360)])
def test_arcs_pass_through_a_turn(rise):
    """All of them are the arc from 300 deg through 0 to 40 deg; the return from 100 to 290 deg follows."""
    motion = RiseAndReturn(LAW, 2.0, (rise[0] * DEG, rise[1] * DEG), (100 * DEG, 290 * DEG))
    phi = np.array([300, 325, 350, 15, 40, 70, 99.9, 195, 290, 299.9]) * DEG
    assert motion(phi) == pytest.approx(2 * np.array([0, LAW(0.25), 0.5, LAW(0.75), 1, 1, 1, 0.5, 0, 0]), abs=1e-12)


@pytest.mark.parametrize(
    ("stroke", "rise", "back", "sentence"),
    [
        (0.0, (0, 1), None, "law.stroke: given 0.0; must be a finite number other than 0"),
        (1.0, (0, 7), None, "law.rise: given '0 ... 401.07 deg'; must be shorter than a turn of the cam"),
        (1.0, (0, 1), (0.9, 2), "law.return: given '51.5662 ... 114.592 deg'; must not overlap the rise, 0 ... 57.2958 deg"),
        (1.0, (0, 1), (6, 0.1), "law.return: given '343.775 ... 5.72958 deg'; must not overlap the rise"),
        (1.0, (1, 2), (1.2, 1.8), "must not overlap the rise"),
    ],
)
def test_wrong_motions(stroke, rise, back, sentence):
    with pytest.raises(InputError) as error:
        RiseAndReturn(LAW, stroke, rise, back)
    assert sentence in str(error.value)


def test_the_acceleration_jumps_most_where_the_shorter_arc_begins_and_ends():
    """s = (1 - cos(pi x))/2 has s'' = pi^2/2 at its ends; 3-4-5 has none there."""
    arcs = (0.5, 1.5), (2.0, 2.4)
    assert RiseAndReturn(standard_law("harmonic"), -0.03, *arcs).jump == pytest.approx(0.03 * PI**2 / 2 / 0.4**2)
    assert RiseAndReturn(standard_law("3-4-5"), -0.03, *arcs).jump == 0.0


def test_the_acceleration_of_a_parabolic_law_jumps_most_in_the_middle():
    """From 4 to -4."""
    assert RiseAndReturn(standard_law("parabolic"), 0.03, (0.5, 1.5), (2.0, 2.4)).jump == pytest.approx(0.03 * 8 / 0.4**2)
    assert [standard_law(kind).inner_jumps(2).tolist() for kind in ("parabolic", "modified-trapezoid", "3-4-5")] == [
        [0.5],
        [],
        [],
    ]
