"""Averages over turns remove the ripple within a turn and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from wucht.numerics.observers.turns import MARKS_PER_TURN, Samples, TurnObserver, interpolate, shares_at_values

CUBIC = np.polynomial.Polynomial([0.3, -1.2, 0.7, 2.5])
UNIT = np.array([0.0, 1.0])


def hermite(at, x, y, slope):
    """At points, by the samples around each, or by the outermost ones."""
    i = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    return interpolate((at - x[i]) / (x[i + 1] - x[i]), x, y, slope, i)


def test_cubics_are_exact_and_go_on_beyond_the_ends():
    x = np.array([-1.0, -0.4, 0.1, 0.15, 2.0])
    at = np.array([-1.3, -1.0, -0.7, -0.4, 0.0, 0.12, 1.0, 2.0, 2.2])
    both = np.array([CUBIC(x), -2 * CUBIC(x)]), np.array([CUBIC.deriv()(x), -2 * CUBIC.deriv()(x)])
    assert hermite(at, x, CUBIC(x), CUBIC.deriv()(x)) == pytest.approx(CUBIC(at), rel=1e-13, abs=1e-13)
    assert hermite(at, x, *both)[1] == pytest.approx(-2 * CUBIC(at), rel=1e-13, abs=1e-13)


def test_samples_are_met_exactly():
    x = np.array([0.1, 0.4, 1.1, 1.3])
    y, slope = np.sin(7 * x), 7 * np.cos(7 * x)
    i = np.arange(3)
    assert np.array_equal(interpolate(np.zeros(3), x, y, slope, i), y[:-1])
    assert interpolate(np.ones(3), x, y, slope, i) == pytest.approx(y[1:], rel=1e-15)


def test_the_error_is_of_fourth_order():
    """The cubic is off by h^4/384 of the fourth derivative in the middle between samples, where that is alike."""
    errors = []
    for n in (11, 21, 41, 81):
        x = np.linspace(0, 3, n)
        errors.append(np.abs(hermite((x[1:] + x[:-1]) / 2, x, np.sin(x), np.cos(x)) - np.sin((x[1:] + x[:-1]) / 2)).max())
    assert errors == pytest.approx([(3 / n) ** 4 / 384 for n in (10, 20, 40, 80)], rel=0.02)


# Of rise 1, and monotone between as long as both are at most 3 (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17, 1980).
SLOPES = [(a, b) for a in (0.0, 1e-9, 0.5, 1.0, 3.0) for b in (0.0, 1e-9, 0.5, 1.0, 3.0)]


@pytest.mark.parametrize(("first", "last"), SLOPES)
@pytest.mark.parametrize("rise", [1.0, -3e-4, 5e6])
def test_the_place_where_a_monotone_cubic_has_a_value(first, last, rise):
    wanted = np.array([0.0, 1e-12, 1e-7, 1e-3, 0.1, 1 / 3, 0.5, 0.9, 1 - 1e-3, 1 - 1e-7, 1 - 1e-12, 1.0])
    x, y, slope = np.array([2.0, 2.5]), rise * UNIT, 2 * rise * np.array([first, last])
    i = np.zeros(len(wanted), int)
    share = shares_at_values(rise * wanted, x, y, slope, i)
    assert ((share >= 0) & (share <= 1)).all()
    assert interpolate(share, x, y, slope, i) / rise == pytest.approx(wanted, rel=0, abs=2e-14)


def test_a_body_that_starts_from_rest():
    """y = s^2: the slope at the beginning is zero."""
    y = np.array([1e-8, 1e-4, 0.01, 0.25, 0.81])
    share = shares_at_values(y, UNIT, UNIT, np.array([0.0, 2.0]), np.zeros(5, int))
    assert share == pytest.approx(np.sqrt(y), rel=1e-9)


def test_a_cubic_that_overshoots_is_met_once_between_its_ends():
    y, slope, i = np.array([0.0, 1.0]), np.array([-2.0, 9.0]), np.zeros(5, int)
    wanted = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    share = shares_at_values(wanted, UNIT, y, slope, i)
    assert ((share >= 0) & (share <= 1)).all()
    assert interpolate(share, UNIT, y, slope, i) == pytest.approx(wanted, abs=1e-13)


def test_one_place_does_not_depend_on_the_others_that_are_sought():
    draw = np.random.default_rng(1)
    x, y = np.arange(401.0), np.cumsum(draw.uniform(0.5, 1.5, 401))
    slope = draw.uniform(0.0, 1.5, 401) * (draw.random(401) < 0.7)
    i = np.arange(400)
    wanted = y[i] + draw.random(400) ** 4 * np.diff(y)
    alone = [shares_at_values(wanted[[k]], x, y, slope, i[[k]])[0] for k in i]
    assert np.array_equal(shares_at_values(wanted, x, y, slope, i), alone)


def turns(time, *motions):
    return TurnObserver().update(Samples.of(time, *motions))[1]


def rippled(w, a, samples_a_turn, count=20, k=1):
    """phi = w t + a sin(k w t): whatever a, a turn takes 2 pi/w."""
    t = np.arange(0, count * samples_a_turn + 1) * 2 * np.pi / w / samples_a_turn
    return t, w * t + a * np.sin(k * w * t), w + a * k * w * np.cos(k * w * t)


@pytest.mark.parametrize("w", [0.7, 200.0])
@pytest.mark.parametrize("k", [1, 2, 3])
def test_the_mean_speed_of_a_rippled_turn_is_exact(w, k):
    t, phi, speed = rippled(w, 0.2, 200, k=k)
    averaged = turns(t, (phi, speed))
    assert averaged.speed == pytest.approx(np.full(len(averaged.speed), w), rel=1e-7)
    assert averaged.count == pytest.approx(19, abs=0.2)
    assert np.diff(averaged.angle) == pytest.approx(2 * np.pi / MARKS_PER_TURN, rel=1e-12)


def test_the_error_is_of_fourth_order_in_the_sampling_interval():
    errors = []
    for samples_a_turn in (12.382, 24.382, 48.382, 96.382):  # out of step, so that errors do not repeat and cancel
        t = np.arange(0, 1200, 2 * np.pi / samples_a_turn)
        averaged = turns(t, (t + 0.2 * np.sin(t), 1 + 0.2 * np.cos(t)))
        errors.append(np.abs(averaged.speed - 1.0).max())
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert order == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize("samples_a_turn", [24, 32])
def test_samples_on_the_marks_are_kept_as_they_are(samples_a_turn):
    t = np.arange(10 * samples_a_turn + 1) * 2 * np.pi / samples_a_turn
    on_marks = t[:: samples_a_turn // MARKS_PER_TURN]
    averaged = turns(t, (t, np.ones_like(t)), (3 * t, np.full_like(t, 3.0)))
    assert averaged.time == pytest.approx(on_marks[1 + MARKS_PER_TURN :], rel=1e-15)
    assert averaged.angles[0] == pytest.approx(3 * on_marks[1 + MARKS_PER_TURN :], rel=1e-15)
    assert averaged.speed == pytest.approx(1.0, rel=1e-14)


def test_a_sample_hardly_before_a_mark_is_at_it():
    """Within 1e-9 of the way from mark to mark: rounding of the angle must not decide whether a turn is over."""
    step = 2 * np.pi / MARKS_PER_TURN

    def count(last):
        t = np.linspace(-0.5 * step, last, 60)
        return len(turns(t, (t, np.ones_like(t))).time)

    assert count((MARKS_PER_TURN + 2 - 0.7e-9) * step) == count((MARKS_PER_TURN + 2.5) * step) == 3
    assert count((MARKS_PER_TURN + 2 - 1.4e-9) * step) == 2


def test_a_slow_change_is_kept():
    """phi = t + t^2/2000: the mean speed over a turn that takes T around the middle t is 1 + t/1000."""
    t = np.linspace(0, 300, 6001)
    averaged = turns(t, (t + t**2 / 2000, 1 + t / 1000))
    assert averaged.speed == pytest.approx(1 + averaged.middle / 1000, rel=1e-9)
    assert (averaged.time - averaged.middle) * 2 * averaged.speed == pytest.approx(2 * np.pi, rel=1e-10)
    assert averaged.angle == pytest.approx(averaged.time + averaged.time**2 / 2000, rel=1e-9)


def test_followers_their_speed_and_phase():
    t, phi, speed = rippled(3.0, 0.1, 100)
    averaged = turns(t, (phi, speed), (phi + 2.0, speed), (2.7 * t, np.full_like(t, 2.7)))
    assert np.abs(averaged.phases[0] - np.exp(2j)).max() < 1e-6
    assert averaged.advance * averaged.speed / (2 * np.pi) == pytest.approx(np.array([[3.0], [2.7]]) + 0 * averaged.advance)
    assert averaged.angles == pytest.approx(np.array([averaged.angle + 2.0, 2.7 * averaged.time]), rel=1e-6)
    # A slip of a tenth of the speed turns the phase by 36 degrees a turn: the mean of exp(i a) over that has modulus sinc.
    assert np.abs(averaged.phases[1]).mean() == pytest.approx(np.sin(0.1 * np.pi) / (0.1 * np.pi), abs=2e-2)


def test_the_mean_phase_is_that_of_the_trapezoidal_rule():
    """exp(i (other - leading)) = exp(-i t/10) of 2 pi/N + 2 pi: its mean over a turn is known in closed form."""
    t = np.arange(0, 40, 2 * np.pi / 48)
    averaged = turns(t, (t, np.ones_like(t)), (0.9 * t, np.full_like(t, 0.9)))
    half = 0.1 * np.pi / MARKS_PER_TURN  # of what the phase turns from mark to mark
    exact = np.exp(-0.1j * averaged.middle) * np.sin(0.1 * np.pi) / (MARKS_PER_TURN * np.tan(half))
    assert np.abs(averaged.phases[0] - exact).max() < 1e-12


def test_turning_backward():
    t, phi, speed = rippled(3.0, 0.1, 100)
    forward = turns(t, (phi, speed), (phi + 2.0, speed))
    backward = turns(t, (-phi, -speed), (-phi - 2.0, -speed))
    assert np.array_equal(backward.speed, -forward.speed)
    assert np.array_equal(backward.angle, -forward.angle)
    assert np.array_equal(backward.advance, -forward.advance)
    assert np.abs(backward.phases - forward.phases.conj()).max() < 1e-15


def test_the_unit_of_time_does_not_matter():
    t, phi, speed = rippled(3.0, 0.1, 50.0)
    in_seconds, in_parts = turns(t, (phi, speed)), turns(1024 * t, (phi, speed / 1024))
    assert np.array_equal(in_parts.time, 1024 * in_seconds.time)
    assert np.array_equal(in_parts.speed, in_seconds.speed / 1024)


def test_a_body_that_turns_back_begins_anew():
    """phi = 40 sin(t/10): 40 rad on, 80 back, 80 on."""
    t = np.linspace(0, 25 * np.pi, 20_001)
    averaged = turns(t, (40 * np.sin(t / 10), 4 * np.cos(t / 10)))
    assert [int((averaged.passage == k).sum()) for k in range(3)] == [
        int(radians * MARKS_PER_TURN / (2 * np.pi)) - MARKS_PER_TURN for radians in (40, 80, 80)
    ]
    assert (np.sign(averaged.speed) == 1 - 2 * (averaged.passage % 2)).all()
    back = averaged.passage == 1
    assert averaged.time[back].min() > 5 * np.pi
    assert averaged.time[back].max() < 15 * np.pi
    assert np.array_equal(np.unique(averaged.passage), [0, 1, 2])


def test_the_turns_of_each_passage_are_complete():
    """On by 3.05 turns and back three times, in steps of about a tenth of a turn: longer than from mark to mark."""
    there = 3.05 * 2 * np.pi * np.linspace(0, 1, 31)
    angle = np.concatenate([there, there[-2::-1], there[1:], there[-2::-1]])
    speed = np.zeros_like(angle)
    averaged = turns(np.arange(121.0), (angle, speed))
    assert [int((averaged.passage == k).sum()) for k in range(4)] == [2 * MARKS_PER_TURN, 2 * MARKS_PER_TURN + 1] * 2
    fewer = turns(np.arange(121.0), (angle * 1.55 / 3.05, speed))
    assert [int((fewer.passage == k).sum()) for k in range(4)] == [MARKS_PER_TURN // 2, MARKS_PER_TURN // 2 + 1] * 2


def test_a_body_that_swings_makes_no_turns():
    t = np.linspace(0, 100, 4001)
    observer, averaged = TurnObserver().update(Samples.of(t, (3.1 * np.sin(t), 3.1 * np.cos(t))))
    assert averaged.count == 0
    assert observer.passage == 32  # t = pi/2 + k pi


def test_a_body_that_swings_at_first():
    """Speed 1 - 2 exp(-t/5), negative until t = 5 ln 2."""
    t = np.linspace(0, 100, 4001)
    averaged = turns(t, (t + 10 * (np.exp(-t / 5) - 1), 1 - 2 * np.exp(-t / 5)))
    assert (averaged.speed > 0).all()
    assert averaged.time[0] > 5 * np.log(2)
    assert averaged.speed[-1] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("until", [0.0, 0.1, 6.0])
def test_less_than_a_turn_is_an_empty_record(until):
    t = np.linspace(0, until, 30)
    averaged = turns(t, (t, np.ones_like(t)), (t, np.ones_like(t)))
    assert averaged.count == 0
    assert averaged.phases.shape == averaged.advance.shape == averaged.angles.shape == (1, 0)


def with_distance(t, square, rate):
    samples = replace(Samples.of(t, (t, np.ones_like(t))), square=square, rate=rate)
    return TurnObserver().update(samples)[1]


def test_the_largest_distance_in_a_turn_is_of_fourth_order():
    """Of r^2 = 1 + cos(2.3 t)/2, which has maxima in every turn: off by h^4/384 of half of 2.3^4 at the most."""
    for samples_a_turn in (24.382, 48.382, 96.382):
        h = 2.3 * 2 * np.pi / samples_a_turn
        t = np.arange(0, 1200, 2 * np.pi / samples_a_turn)
        averaged = with_distance(t, 1 + 0.5 * np.cos(2.3 * t), -1.15 * np.sin(2.3 * t))
        error = np.abs(averaged.largest - np.sqrt(1.5)).max()
        assert error < h**4 / 384 / 2 / (2 * np.sqrt(1.5)) * 1.05
    assert error > 0.2 * h**4 / 384 / 2 / (2 * np.sqrt(1.5))


def test_a_peak_counts_in_the_turns_that_it_lies_in():
    """At t = 50.03 between two samples, far from a mark."""
    t = np.linspace(0, 100, 2001)
    peak = 8 * np.exp(-(((t - 50.03) / 0.05) ** 2))
    averaged = with_distance(t, 1 + peak, -800 * (t - 50.03) * peak)
    inside = (averaged.time > 50.03) & (averaged.time - 2 * np.pi / averaged.speed < 50.03)
    assert inside.sum() == MARKS_PER_TURN
    assert averaged.largest[inside] == pytest.approx(3.0, rel=0.02)
    assert averaged.largest[~inside].max() < 1.01


@pytest.mark.parametrize("overlap", [0, 1])
def test_a_sample_that_two_parts_of_a_motion_share_counts_once(overlap):
    time = np.linspace(0.0, 1.0, 11)
    motion = Samples.of(time, (7 * time, np.full(11, 7.0)), (3 * time, np.full(11, 3.0)))
    whole = motion.part(slice(5 - overlap, None)).with_previous(motion.part(slice(5)))
    for name, values in vars(motion).items():
        assert np.array_equal(getattr(whole, name), values), name


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_middle_of_a_turn_lies_half_its_time_before_its_end(sense):
    """Turns of 2 s, eight averages each."""
    time = np.linspace(0.0, 9.0, 901)
    _, turns = TurnObserver().update(Samples.of(time, (sense * np.pi * time, np.full(901, sense * np.pi))))
    assert turns.middle == pytest.approx(turns.time - 1.0) and turns.speed == pytest.approx(
        np.full(len(turns.time), sense * np.pi)
    )
    assert turns.count == pytest.approx(len(turns.time) / 8)


def of_bodies():
    """Three bodies whose angles, speeds and moments are known by their numbers."""
    base = np.arange(3.0)[:, None] + np.zeros(2)
    return replace(Samples.of(np.array([0.0, 1.0]), *zip(base, 10 + base, strict=True)), moments=100 + base)


@pytest.mark.parametrize(("body", "order"), [(0, [0, 1, 2]), (1, [1, 0, 2]), (2, [2, 0, 1])])
def test_samples_relative_to_a_body(body, order):
    found = of_bodies().relative_to(body)
    assert found.angles[:, 0].tolist() == order
    assert found.speeds[:, 0].tolist() == [10 + i for i in order] and found.moments[:, 0].tolist() == [100 + i for i in order]
    one = of_bodies().only_body(body)
    assert (one.angles[:, 0].tolist(), one.speeds[:, 0].tolist(), one.moments[:, 0].tolist()) == (
        [body],
        [10 + body],
        [100 + body],
    )


def test_samples_with_another_leading_motion():
    angle, speed = np.array([7.0, 8.0]), np.array([0.5, 0.25])
    put = of_bodies().with_reference(angle, speed)
    assert put.angles.tolist() == [[7.0, 8.0], [0, 0], [1, 1], [2, 2]] and put.speeds[:2].tolist() == [[0.5, 0.25], [10, 10]]
    assert put.moments.tolist() == [[0, 0], [100, 100], [101, 101], [102, 102]], "it has no weight"
    replaced = of_bodies().with_leading(angle, speed)
    assert replaced.angles.tolist() == [[7.0, 8.0], [1, 1], [2, 2]] and replaced.speeds[:2].tolist() == [[0.5, 0.25], [11, 11]]
