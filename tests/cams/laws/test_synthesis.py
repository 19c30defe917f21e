"""Harmonic synthesis: against closed forms, against other ways to the same optimum, and restrictions on both sides."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from wucht.cams.laws import synthesis
from wucht.cams.laws.cone_programme import InfeasibleError
from wucht.cams.laws.synthesis import Band, Cap, equiripple, maximally_flat, single_relaxations, synthesise
from wucht.errors import RunError
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
STROKE = 0.4
TOP = Band("top", 0, math.pi, math.pi, STROKE, STROKE)


def dwell(half, tolerance=0.0, value=0.0):
    """As flat as can be without a tolerance."""
    return Band("dwell", 0, -half, half, value - tolerance, value + tolerance, is_widened=not tolerance)


def everywhere(order, bound, widened=False):
    return Band(f"derivative {order}", order, 0.0, TURN, -bound, bound, widened)


def arc(half, count=40_001):
    return np.linspace(-half, half, count)


@pytest.mark.parametrize(
    ("count", "degrees"), [(2, 120), (5, 120), (5, 90), (8, 90), (12, 120), (12, 90), (20, 120)], ids=lambda x: f"{x:g}"
)
def test_the_flattest_dwell_is_chebyshevs(count, degrees):
    """Down to 1e-9 of the stroke. The programme is solved, and arcs are enforced, to a millionth of the ripple."""
    half = math.radians(degrees)
    found, best = synthesise(count, [dwell(half), TOP]), equiripple(count, half, STROKE)
    ripple = STROKE / math.cosh(count * math.acosh((3 + math.cos(half)) / (1 - math.cos(half))))
    assert found.widening == pytest.approx(ripple, rel=2e-6)
    assert np.abs(found.law(arc(half))).max() == pytest.approx(ripple, rel=2e-6)
    assert found.law(math.pi) == pytest.approx(STROKE, rel=1e-12)
    phi = np.linspace(0, TURN, 999)
    assert found.law(phi) == pytest.approx(best(phi), abs=1e-4 * ripple + 1e-6 * STROKE)


def test_the_figures_of_the_cases():
    """Five harmonics: 243/29525 of the stroke for a dwell of 240 degrees, 1/3363 for 180."""
    for degrees, ripple in ((120, 243 / 29525), (90, 1 / 3363)):
        assert synthesise(5, [dwell(math.radians(degrees)), TOP]).widening == pytest.approx(STROKE * ripple, rel=1e-7)


def test_closed_forms():
    ten = maximally_flat(5)
    assert 1024 * np.append(ten.mean, ten.cosine) == pytest.approx([252, -420, 240, -90, 20, -2])
    phi = np.linspace(0, TURN, 99)
    assert ten(phi) == pytest.approx(np.sin(phi / 2) ** 10)
    assert equiripple(5, math.pi / 2).peak == pytest.approx(1.0)


def test_least_peak_acceleration_is_that_of_a_linear_programme_on_a_fine_grid():
    count, half, tolerance = 7, math.radians(60), 1e-3
    found = synthesise(count, [dwell(half, tolerance), TOP, everywhere(2, 0.0, widened=True)])
    k, phi = np.arange(1, count + 1), np.linspace(-math.pi, math.pi, 2001)

    def rows(at, order):
        turned = np.multiply.outer(at, k) + order * math.pi / 2
        return np.hstack([np.full((len(at), 1), float(order == 0)), k**order * np.cos(turned), k**order * np.sin(turned)])

    flat, bent = rows(arc(half, 501), 0), rows(phi, 2)
    zero, one = np.zeros((len(flat), 1)), np.ones((len(bent), 1))
    on_grid = linprog(
        np.append(np.zeros(2 * count + 1), 1.0),
        np.vstack([np.hstack([s * flat, zero]) for s in (1, -1)] + [np.hstack([s * bent, -one]) for s in (1, -1)]),
        np.concatenate([np.full(2 * len(flat), tolerance), np.zeros(2 * len(bent))]),
        np.append(rows(np.array([math.pi]), 0), [[0.0]], axis=1),
        [STROKE],
        bounds=[(None, None)] * (2 * count + 2),
    )
    assert found.widening == pytest.approx(on_grid.fun, rel=1e-4)  # a grid knows less than the arc
    assert found.widening >= on_grid.fun * (1 - 1e-6)
    assert found.law.derivative(2).peak == found.widening
    assert np.abs(found.law(arc(half))).max() <= tolerance * (1 + 1e-6)


def test_least_mean_square_acceleration_has_the_closed_form_of_lagranges_multiplier():
    """Of two precision points alone: A_k is proportional to (cos k pi - 1)/k^4, for odd k."""
    k = np.arange(1, 8)
    found = synthesise(7, [TOP, Band("bottom", 0, 0.0, 0.0, 0.0, 0.0)], k**2).law
    shape = np.where(k % 2 == 1, 1.0 / k**4, 0.0)
    assert found.cosine == pytest.approx(-STROKE / 2 * shape / shape.sum(), abs=1e-9)
    assert found.sine == pytest.approx(np.zeros(7), abs=1e-9)
    assert found.mean == pytest.approx(STROKE / 2)


def test_a_large_weight_drives_a_harmonic_to_zero():
    """As near a resonance: its amplitude falls with the square of the weight."""
    k = np.arange(1, 9)
    near = k**2 * np.where(k == 4, 100.0, 1.0)
    plain, tuned = (synthesise(8, [dwell(math.radians(60), 1e-3), TOP], w).law for w in (k**2, near))
    assert tuned.amplitudes[3] < 1e-2 * plain.amplitudes[3]
    assert tuned(math.pi) == pytest.approx(STROKE)


def test_caps_hold_per_harmonic():
    k = np.arange(1, 9)
    asked = [dwell(math.radians(60), 1e-3), TOP]
    free = synthesise(8, asked, k**2).law
    capped = synthesise(8, [*asked, Cap("second", 2, free.amplitudes[1] / 2), Cap("fifth", 5, 0.0)], k**2).law
    assert capped.amplitudes[1] == pytest.approx(free.amplitudes[1] / 2, rel=1e-6)
    assert capped.amplitudes[4] < 1e-8
    assert np.abs(capped(arc(math.radians(60)))).max() <= 1e-3 * (1 + 1e-6)


def test_a_cap_holds_with_a_tightest_dwell_too():
    half = math.radians(90)
    free = synthesise(5, [dwell(half), TOP])
    capped = synthesise(5, [dwell(half), TOP, Cap("fourth", 4, 0.5 * free.law.amplitudes[3])])
    assert capped.law.amplitudes[3] == pytest.approx(0.5 * free.law.amplitudes[3], rel=1e-6)
    assert capped.widening > 1.01 * free.widening


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_bounds_hold_between_the_angles_looked_at(order):
    half = math.radians(100)
    asked = [dwell(half), TOP]
    free = synthesise(8, asked).law.derivative(order).peak
    bound = (0.999 if order == 0 else 0.9) * free
    asked = [dwell(half), *([] if order == 0 else [TOP]), Band("rise", 0, math.pi, math.pi, 0.9 * STROKE, math.inf)]
    found = synthesise(8, [*asked, everywhere(order, bound)]).law
    assert found.derivative(order).peak <= bound * (1 + 1e-6)


@pytest.mark.parametrize("half", [0.971186440677966, 1.011864406779661, 1.1338983050847458])
def test_a_dwell_whose_ripple_rounding_hides_is_found_beside_a_bound(half):
    """With so little to widen a programme may fail in the unit of the one before; it is solved in its own."""
    top, bound = Band("top", 0, math.pi, math.pi, 0.6716, 0.6716), everywhere(1, 2.7957)
    found = synthesise(8, [top, dwell(half), bound])
    assert found.widening < 1e-6
    assert found.law.derivative().peak <= 2.7957 * (1 + 1e-6)


def test_one_sided_bounds_and_arcs_beyond_a_turns_end():
    """A second dwell at the top, from 170 to 190 degrees, of which one bound is left open; arcs count from where they begin."""
    top = Band("top", 0, math.radians(170), math.radians(190), STROKE, math.inf)
    low = Band("bottom", 0, math.radians(300), math.radians(420), -1e-3, 1e-3)
    found = synthesise(9, [top, low], np.arange(1, 10) ** 2).law
    assert found(np.radians([170, 180, 190])).min() >= STROKE * (1 - 1e-6)
    assert np.abs(found(arc(math.radians(60)))).max() <= 1e-3 * (1 + 1e-6)
    assert found.peak > STROKE * (1 + 1e-6)


CONTRADICTION = [
    dwell(math.radians(60), 1e-3),
    TOP,
    Band("velocity", 1, 0.0, TURN, -0.3, 0.3),
]


def test_restrictions_that_contradict_each_other_are_infeasible():
    for weights in (None, np.arange(1, 4) ** 2):
        with pytest.raises(InfeasibleError):
            synthesise(3, CONTRADICTION, weights)


def test_what_must_give_way_and_by_how_much():
    ways = single_relaxations(3, CONTRADICTION)
    assert {restriction.name for restriction, _ in ways} == {"dwell", "top", "velocity"}
    assert ways[0][0].name == "velocity"  # by 0.025 of 0.6: the least share
    for r, least in ways:
        for share, feasible in ((0.999, False), (1.001, True)):
            by = share * least
            eased = [Band(b.name, b.order, b.begin, b.end, b.low - by, b.high + by) if b == r else b for b in CONTRADICTION]
            if feasible:
                synthesise(3, eased, np.arange(1, 4) ** 2)
            else:
                with pytest.raises(InfeasibleError):
                    synthesise(3, eased, np.arange(1, 4) ** 2)


def test_where_more_than_one_must_give_way_there_is_no_way_out():
    points = [Band(f"point {i}", 0, 0.0, 0.0, float(i), float(i)) for i in range(3)]
    assert single_relaxations(4, points) == ()


def test_a_motion_that_the_solver_cannot_compute_is_not_called_infeasible(monkeypatch):
    """A point that is met to rounding contradicts nothing: the error is the solver's."""
    exchange = synthesis._solve_by_exchange

    def without_dwell(count, restrictions, weights):
        if any(r.name == "dwell" for r in restrictions):
            raise RunError("no motion law could be computed")
        return exchange(count, restrictions, weights)

    monkeypatch.setattr(synthesis, "_solve_by_exchange", without_dwell)
    with pytest.raises(RunError, match="no motion law could be computed"):
        synthesise(7, [dwell(1.26), TOP])


@settings(max_examples=25, deadline=None)
@example(7, 1.261116602935225, 0.0, 1.0)  # with BLAS kernels for Haswell it was not computed
@given(st.integers(3, 8), st.floats(1.2, 2.2), st.floats(-3, 3), st.floats(0.01, 100))
def test_turning_and_scaling_the_task_turns_and_scales_the_motion(count, half, turned, scale):
    """Where the ripple is far above rounding."""
    asked = [dwell(half), TOP]
    other = [
        Band(b.name, b.order, b.begin + turned, b.end + turned, scale * b.low, scale * b.high, b.is_widened) for b in asked
    ]
    found, moved = synthesise(count, asked), synthesise(count, other)
    assert moved.widening == pytest.approx(scale * found.widening, rel=3e-6)
    phi = np.linspace(0, TURN, 200)
    assert moved.law(phi) == pytest.approx(scale * found.law.shift(turned)(phi), abs=1e-4 * scale * STROKE)


def test_the_motion_is_a_series():
    assert isinstance(synthesise(2, [dwell(1.0), TOP]).law, FourierSeries)


@pytest.mark.parametrize(("harmonic", "size"), [(1, 0.2), (2, 0.0), (2, 0.01), (3, 0.0)])
def test_caps_hold_where_few_harmonics_are_enough(harmonic, size):
    """A dwell of two degrees needs two harmonics: a cap on the second or third of the few is one of theirs."""
    law = synthesise(12, [dwell(math.radians(1)), TOP, Cap("cap", harmonic, size)]).law
    free = synthesise(12, [dwell(math.radians(1)), TOP]).law
    assert law.amplitudes[harmonic - 1] <= size + 1e-9 * STROKE
    assert np.count_nonzero(free.amplitudes > 1e-9 * STROKE) == 2
    assert law(math.pi) == pytest.approx(STROKE)
    assert np.abs(law(arc(math.radians(1)))).max() <= 2e-9 * STROKE


@st.composite
def satisfiable(draw):
    """A motion, and restrictions of every kind that it satisfies, points just so."""
    count, chance = draw(st.integers(3, 6)), np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    k = np.arange(1, count + 1)
    motion = FourierSeries(chance.normal(), chance.normal(size=count) / k**2, chance.normal(size=count) / k**2)
    restrictions = []
    for number in range(draw(st.integers(1, 4))):
        order, begin, length = int(chance.integers(0, 4)), chance.uniform(-4, 8), chance.choice([0.0, 0.4, 2.5, TURN])
        values = motion.derivative(order)(np.linspace(begin, begin + length, 2000))
        slack = 0.0 if length == 0.0 else 0.05 * motion.derivative(order).peak
        low, high = values.min() - slack, values.max() + slack
        low, high = [(low, high), (low, math.inf), (-math.inf, high)][chance.integers(3)] if slack else (low, high)
        restrictions.append(Band(f"band {number}", order, begin, begin + length, low, high))
    for harmonic in chance.permutation(k)[: draw(st.integers(0, 2))]:
        restrictions.append(Cap(f"cap {harmonic}", int(harmonic), 1.05 * float(motion.amplitudes[harmonic - 1])))
    return motion, restrictions


def exceeded(restriction, law):
    """By how much a law is beyond a restriction, by sums of its own over a fine grid."""
    k = np.arange(1, law.count + 1)
    if isinstance(restriction, Cap):
        return math.hypot(law.cosine[restriction.harmonic - 1], law.sine[restriction.harmonic - 1]) - restriction.size
    phi = np.linspace(restriction.begin, restriction.end, 2000)[:, None]
    series = law.cosine * np.cos(k * phi) + law.sine * np.sin(k * phi)
    turned = {
        0: law.mean + series.sum(axis=1),
        1: (k * (law.sine * np.cos(k * phi) - law.cosine * np.sin(k * phi))).sum(axis=1),
        2: -(k**2 * series).sum(axis=1),
        3: (k**3 * (law.cosine * np.sin(k * phi) - law.sine * np.cos(k * phi))).sum(axis=1),
    }[restriction.order]
    return max((turned - restriction.high).max(), (restriction.low - turned).max())


@settings(max_examples=25, deadline=None)
@given(satisfiable())
def test_every_restriction_holds_and_no_known_motion_is_better(task):
    """Bands of every derivative on arcs anywhere, one-sided and two-sided, points and caps, of which a motion is known."""
    motion, restrictions = task
    k = np.arange(1, motion.count + 1)
    law = synthesise(motion.count, restrictions, k**2).law
    for r in restrictions:
        scale = motion.derivative(r.order).peak if isinstance(r, Band) else motion.amplitudes.max()
        assert exceeded(r, law) <= 1e-5 * scale, r
    effort, known = (
        float(np.hypot(k**2 * x.cosine, k**2 * x.sine) @ np.hypot(k**2 * x.cosine, k**2 * x.sine)) for x in (law, motion)
    )
    assert effort <= known * (1 + 1e-6)
