"""What a run tends to, against what is known of the equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind, forcing_period
from wucht.dynamics.limit_sets.long_run import LongRun, long_run
from wucht.errors import WuchtError
from wucht.files.user_system import UserSystem, equations_from
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE


def equations(states: dict[str, str], angles: tuple[str, ...] = (), **parameters: float) -> UserSystem:
    return equations_from({"states": states, "angles": list(angles), "parameters": parameters})


def run_of(
    states: dict[str, str],
    start: list[float],
    angles: tuple[str, ...] = (),
    until: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
) -> LongRun:
    return long_run(equations(states, angles), np.array(start), until, tolerance)


def limit_of(run: LongRun) -> LimitSet:
    assert run.limit_set is not None
    return run.limit_set


FOCUS = {"x": "v", "v": "-0.1*v - x"}
NORMAL_FORM = {"x": "x - 2*y - x*(x^2 + y^2)", "y": "2*x + y - y*(x^2 + y^2)"}  # r' = r - r^3, phi' = 2
ROESSLER = {"x": "-y - z", "y": "x + 0.2*y", "z": "0.2 + z*(x - c)"}


def test_a_damped_oscillator_comes_to_its_equilibrium() -> None:
    run = run_of(FOCUS, [1.0, 0.0])
    assert run.kind is MotionKind.EQUILIBRIUM
    assert limit_of(run).attracts is True
    assert limit_of(run).eigenvalues == pytest.approx([-0.05 + 1j * np.sqrt(1 - 0.0025), -0.05 - 1j * np.sqrt(1 - 0.0025)])
    # The amplitude exp(-t/20) falls to a fiftieth of the range of x, within half a swing.
    assert run.settling_time == pytest.approx(20 * np.log(50 / (1 + np.exp(-np.pi / 20))), abs=np.pi)


def test_a_run_that_ends_before_it_is_near_has_not_settled() -> None:
    run = run_of(FOCUS, [1.0, 0.0])
    assert run.settling_time is not None
    inside = run.time < 0.9 * run.settling_time
    assert replace(run, time=run.time[inside], states=run.states[:, inside]).settling_time is None


def test_a_start_on_an_unstable_equilibrium_stays_there() -> None:
    run = run_of({"x": "x - x^3"}, [0.0])
    assert (run.kind, limit_of(run).attracts) == (MotionKind.EQUILIBRIUM, False)


def test_a_limit_cycle_has_its_period_and_its_multiplier() -> None:
    limit = limit_of(run_of(NORMAL_FORM, [0.1, 0.0]))
    assert (limit.kind, limit.attracts) == (MotionKind.PERIODIC, True)
    assert limit.period == pytest.approx(np.pi, rel=1e-9)
    assert limit.multipliers == pytest.approx([np.exp(-2 * np.pi)], rel=1e-6)  # d(r')/dr = -2 at r = 1
    assert np.concatenate([limit.low, limit.high]) == pytest.approx([-1, -1, 1, 1], abs=1e-5)


def test_a_motion_that_tends_to_an_orbit_from_alternate_sides_has_its_shortest_period() -> None:
    """At c = 2.5 the multiplier is -0.77: every second return is nearer than the first."""
    subject = equations(ROESSLER, c=2.5)
    limit = limit_of(long_run(subject, np.array([1.0, 1.0, 0.0])))
    assert limit.period == pytest.approx(5.748991, rel=1e-6)
    assert limit.multipliers[0].real == pytest.approx(-0.76969, abs=1e-4)


def test_an_angle_that_turns_returns_after_a_turn() -> None:
    limit = limit_of(run_of({"a": "w", "w": "1 - w"}, [0.0, 0.0], ("a",)))
    assert (limit.kind, limit.turns.tolist()) == (MotionKind.PERIODIC, [1, 0])
    assert limit.period == pytest.approx(2 * np.pi, rel=1e-9)


def test_a_forced_motion_has_a_multiple_of_the_period_of_its_forcing() -> None:
    limit = limit_of(run_of({"x": "v", "v": "-0.5*v - x + cos(3*t)"}, [0.0, 0.0]))
    assert (limit.kind, limit.period) == (MotionKind.PERIODIC, pytest.approx(2 * np.pi / 3, rel=1e-12))
    assert limit.high[0] == pytest.approx(1 / np.hypot(1 - 9, 1.5), rel=1e-5)  # |1 / (1 - 9 + 1.5 i)|


def test_a_conservative_oscillation_attracts_nothing() -> None:
    limit = limit_of(run_of({"x": "v", "v": "-x"}, [1.0, 0.0]))
    assert (limit.kind, limit.attracts) == (MotionKind.PERIODIC, None)


@pytest.mark.parametrize("states", [{"x": "x^2"}, {"x": "0.1*x"}])
def test_a_motion_that_grows_without_bound_diverges(states: dict[str, str]) -> None:
    """x^2 in a finite time, at t = 1."""
    run = run_of(states, [1.0])
    assert (run.kind, run.limit_set, run.failure) == (MotionKind.DIVERGES, None, None)
    assert states != {"x": "x^2"} or run.end_time == pytest.approx(1.0, abs=2e-3)


def test_a_chaotic_motion_has_an_exponent_with_its_interval() -> None:
    """J. C. Sprott, "Chaos and Time-Series Analysis", Oxford 2003: 0.9056."""
    run = run_of({"x": "10*(y - x)", "y": "x*(28 - z) - y", "z": "x*y - 8/3*z"}, [1.0, 1.0, 1.0])
    exponent = limit_of(run).exponent
    assert run.kind is MotionKind.CHAOTIC
    assert exponent is not None
    assert 0 < exponent.low < 0.9056 < exponent.high


@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-9])
def test_the_noise_of_an_integration_is_rest_at_every_tolerance(tolerance: float) -> None:
    """Steps become as long at rest as they are barely stable, and the noise a multiple of the tolerance."""
    run = run_of({"x": "10*(y - x)", "y": "x*(10 - z) - y", "z": "x*y - 8/3*z"}, [-17.5, -17.5, 0.0], tolerance=tolerance)
    assert run.kind is MotionKind.EQUILIBRIUM
    assert limit_of(run).states[:, 0] == pytest.approx([np.sqrt(24), np.sqrt(24), 9.0])


def test_an_oscillation_of_ten_times_the_noise_is_no_rest() -> None:
    """r' = 5e-4 - r from 1: a circle whose diameter is 1e-3 of the run's extent."""
    grow = "(5e-4/sqrt(x^2 + y^2) - 1)"
    run = run_of({"x": f"-y + x*{grow}", "y": f"x + y*{grow}"}, [1.0, 0.0], tolerance=1e-6)
    assert (run.kind, limit_of(run).period) == (MotionKind.PERIODIC, pytest.approx(2 * np.pi, rel=1e-4))


def test_two_frequencies_without_common_period_cover_a_torus() -> None:
    run = run_of({"x": "v", "v": "(0.1 - x^2)*v - x + 0.05*cos(1.6180339887*t)"}, [1.0, 0.0])
    assert run.kind is MotionKind.QUASI_PERIODIC


def test_a_run_that_is_too_short_says_how_long_it_should_be() -> None:
    run = run_of(FOCUS, [1.0, 0.0], until=10.0)
    assert (run.kind, run.advised_time) == (MotionKind.NOT_SETTLED, 40.0)
    assert (run.time[0], run.time[-1], len(run.time)) == (0.0, 10.0, 40_001)


w = np.sqrt(1 - 0.0025)


def test_a_motion_that_sticks_at_a_jump_fails_with_advice() -> None:
    run = run_of({"x": "v", "v": "-x - 0.3*sign(v)"}, [1.0, 0.0], until=20.0)
    assert run.kind is MotionKind.FAILED
    assert "slides along a jump" in str(run.failure)
    assert run.end_time == pytest.approx(np.pi * 2, abs=0.2)  # after two half swings, at |x| = 0.2 or less


def test_the_period_of_the_forcing_is_that_of_all_frequencies_together() -> None:
    subject = equations({"x": "cos(2*w*t) + sin(3*w*t + x)"}, w=0.5)
    assert forcing_period(subject.system, subject.values) == pytest.approx(4 * np.pi)
    alone = equations({"x": "-x + cos(w*t)"}, w=0.5)
    assert forcing_period(alone.system, alone.values) == pytest.approx(4 * np.pi)
    assert forcing_period(equations({"x": "exp(-t)"}).system, {}) is None
    with pytest.raises(WuchtError, match="no common period"):
        forcing_period(equations({"x": "cos(t) + cos(sqrt(2)*t)"}).system, {})


def test_a_state_that_starts_at_its_equilibrium_does_not_keep_a_motion_from_rest() -> None:
    """x moves by rounding alone, y from 5/3 to 1."""
    run = run_of({"x": "x - x^3", "y": "y - y^3"}, [-1.0, 5 / 3])
    assert (run.kind, limit_of(run).attracts) == (MotionKind.EQUILIBRIUM, True)
    assert limit_of(run).mean == pytest.approx([-1, 1], abs=1e-9)
    assert run.end_time < 1000


def test_a_motion_ends_in_a_saddle_if_it_rests_there_for_longer_than_rounding_can() -> None:
    """x' = (x - x^3)/100: from 1e-15 it rests at 0 for 3450 units, but for rounding; from 0 it never leaves."""
    states = {"x": "0.01*(x - x^3)", "y": "-y"}
    stays, leaves = (limit_of(run_of(states, [x, 1.0])) for x in (0.0, 1e-15))
    assert (stays.attracts, stays.mean[0]) == (False, 0.0)
    assert (leaves.attracts, leaves.mean[0]) == (True, pytest.approx(1.0))


def test_a_start_on_an_unstable_equilibrium_is_known_though_rounding_moves_it() -> None:
    """A damped pendulum upside down, where sin(pi) is 1e-16."""
    states = {"x": "v", "v": "-sin(x) - 0.1*v"}
    for x, lies in ((np.pi, True), (np.pi - 1e-3, False)):
        run = run_of(states, [x, 0.0], ("x",))
        assert (run.start_equilibrium is not None) is lies
        assert run.start_equilibrium is None or run.start_equilibrium.attracts is False
        assert np.cos(limit_of(run).mean[0]) == pytest.approx(1.0)


DUFFING = {"x": "v", "v": "-d*v + x - x^3 + 0.3*cos(th)", "th": "1"}


# By ``mean_growth`` of 256 motions over 10,000 units each, with its standard error.
KNOWN_EXPONENTS = {0.15: (0.18365, 0.0002), 0.25: (0.11784, 0.0002)}


def mean_growth(damping: float, starts: np.ndarray, duration: float) -> np.ndarray:
    """Exponents (N,) of N motions of DUFFING by G. Benettin's method, with 314 classical Runge-Kutta steps a period."""
    y = np.vstack([starts, np.ones(starts.shape[1]), np.zeros(starts.shape[1])])
    steps, periods = 314, round(duration / (2 * np.pi))
    h, growth = 2 * np.pi / steps, np.zeros(starts.shape[1])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        x, v, a, b = y
        return np.array([v, -damping * v + x - x**3 + 0.3 * np.cos(t), b, -damping * b + (1 - 3 * x**2) * a])

    for period in range(-periods // 10, periods):
        for t in h * np.arange(steps):
            first = rates(t, y)
            second = rates(t + h / 2, y + h / 2 * first)
            third = rates(t + h / 2, y + h / 2 * second)
            y = y + h / 6 * (first + 2 * second + 2 * third + rates(t + h, y + h * third))
        lengths = np.hypot(y[2], y[3])
        y[2:] /= lengths
        growth += np.log(lengths) if period >= 0 else 0.0
    return growth / (2 * np.pi * periods)


@pytest.mark.slow
@pytest.mark.parametrize(("damping", "until"), [(0.15, None), (0.25, 10_000.0)])
def test_a_driven_oscillator_with_two_wells_is_chaotic(damping: float, until: float | None) -> None:
    """To three standard errors of the estimate (its interval has 2.09, as Student's of 20 blocks) and of what is known."""
    run = long_run(equations(DUFFING, ("th",), d=damping), np.array([1.0, 0.0, 0.0]), until)
    known, known_error = KNOWN_EXPONENTS[damping]
    exponent = limit_of(run).exponent
    assert (run.kind, limit_of(run).attracts) == (MotionKind.CHAOTIC, None)
    assert exponent is not None
    half = (exponent.high - exponent.low) / 2
    assert half <= 0.03 * exponent.value, "0.02 is aimed at"
    assert exponent.value == pytest.approx(known, abs=3 * np.hypot(half / 2.09, known_error))


@pytest.mark.slow
def test_intervals_of_the_exponent_hold_in_nineteen_of_twenty_cases() -> None:
    """From 20 starts; 16 or fewer hold by chance in 1.6 % of cases. The mean has no bias."""
    random = np.random.default_rng(5)
    starts = np.array([random.uniform(-1, 1, 20), random.uniform(-0.5, 0.5, 20)])
    witness = mean_growth(0.15, starts, 5000.0)
    known, error = KNOWN_EXPONENTS[0.15]
    assert witness.mean() == pytest.approx(known, abs=3 * np.hypot(witness.std(ddof=1) / 20**0.5, error))
    subject = equations(DUFFING, ("th",), d=0.15)
    limits = [limit_of(long_run(subject, np.array([*start, 0.0]))).exponent for start in starts.T]
    exponents = [e for e in limits if e is not None]
    assert sum(e.low < known < e.high for e in exponents) >= 17
    values = np.array([e.value for e in exponents])
    assert values.mean() == pytest.approx(known, abs=3 * np.hypot(values.std(ddof=1) / len(values) ** 0.5, error))


def test_what_a_shorter_record_shows_stands_until_a_longer_one_shows_something_else() -> None:
    """Lorenz' equations at r = 23.6, below 24.06: a chaotic motion ends at rest, which is proved (eigenvalues)."""
    lorenz = {"x": "10*(y - x)", "y": "x*(23.6 - z) - y", "z": "x*y - 8/3*z"}
    short, long = (run_of(lorenz, [1.0, 1.0, 1.0], until=until) for until in (60.0, 2000.0))
    assert short.kind in (MotionKind.CHAOTIC, MotionKind.NOT_SETTLED)
    assert (long.kind, limit_of(long).attracts) == (MotionKind.EQUILIBRIUM, True)
    assert np.abs(limit_of(long).mean) == pytest.approx([np.sqrt(8 / 3 * 22.6)] * 2 + [22.6])


@pytest.mark.parametrize(("growth", "kind"), [(2.0, MotionKind.QUASI_PERIODIC), (40.0, MotionKind.CHAOTIC)])
def test_changes_do_not_grow_on_a_torus(growth: float, kind: MotionKind) -> None:
    """Two angles turn at 1 and the golden section; beside them y' = a y: changes grow by e^2 and e^40 over half the run."""
    states = {"p": "1", "q": "1.6180339887", "y": f"{growth / 4000}*y"}
    run = run_of(states, [0.0, 0.0, 0.0], ("p", "q"), until=8000.0)
    assert run.kind is kind
    assert limit_of(run).exponent is not None


def test_a_decay_that_is_slower_than_any_exponential_is_no_torus() -> None:
    """x' = y, y' = -x^3 - 0.1 y^3 loses energy wherever y is not 0: the amplitude falls as a power of the time, to 0."""
    run = run_of({"x": "y", "y": "-x^3 - 0.1*y^3"}, [1.0, 0.0], until=60_000.0)
    first, last = (np.ptp(run.states[0][mask]) for mask in (run.time < 600, run.time > 59_000))
    assert last < 0.2 * first
    assert (run.kind, run.advised_time) == (MotionKind.NOT_SETTLED, 240_000.0)


@pytest.mark.slow
def test_an_angle_that_turns_and_is_not_declared_covers_no_torus() -> None:
    """x'' + x'/10 + sin x = 1/2 turns for ever: with x as a plain number the states return nowhere; as an angle, every turn."""
    turning = {"x": "y", "y": "-sin(x) - 0.1*y + 0.5"}
    assert run_of(turning, [0.0, 3.0]).kind is MotionKind.NOT_SETTLED
    assert run_of(turning, [0.0, 3.0], angles=("x",)).kind is MotionKind.PERIODIC
