"""The numbers of 002 (3.7)-(3.13): against exact ones, and as bounds of true errors."""

import math

import numpy as np
import sympy as sp
from pytest import approx, mark, raises
from scipy.integrate import solve_ivp
from tests.refusals import rejected

from wucht.errors import WuchtError
from wucht.mechanics.averaging import averaged
from wucht.mechanics.standard_form import with_amplitude_and_phase
from wucht.numerics.averaging_error import averaging_error
from wucht.system import TIME, System

x, v, r, psi, epsilon = sp.symbols("x v r psi epsilon", real=True)
TURN = 2 * math.pi
SWUNG = System((x,), (epsilon * (-x + x * sp.cos(TIME)),), (epsilon,))


def estimates(system, small, box, **more):
    return averaging_error(system, averaged(system, epsilon).system, "epsilon", {"epsilon": small}, box, **more)


def test_numbers_that_are_known():
    """X = x (cos t - 1), |x| <= 3: M = 6, lambda = 2, |int_0^t x cos| <= 3. Extremes lie on the grid."""
    error = estimates(SWUNG, 0.01, {"x": (-3.0, 3.0)}, period=TURN)
    assert error.bound_of_rate == approx(6, rel=1e-12)
    assert error.lipschitz == approx(2, rel=1e-12)
    # Simpson's rule with 128 steps a period: its error is (2 pi/128)^4/180 = 3e-8 of the integrand's size.
    assert error.delta == approx(0.03, rel=1e-7)
    assert error.order == approx(math.sqrt(0.03), rel=1e-7)


def test_norms_of_two_states():
    """X = (2 y cos t, x): |X| at the corner (1, 1) is sqrt 5, the spectral norm of [[0, 2 c], [1, 0]] is 2."""
    two = System((x, v), (2 * epsilon * v * sp.cos(TIME), epsilon * x), (epsilon,))
    error = estimates(two, 0.1, {"x": (0, 1), "v": (0, 1)}, period=TURN)
    assert error.bound_of_rate == approx(math.sqrt(5), rel=1e-12)
    assert error.lipschitz == approx(2, rel=1e-12)
    assert error.delta == approx(0.1 * 2, rel=1e-7)


def test_3_13_as_printed():
    """2 lambda M epsilon^2 T^2 (N + 1) exp(epsilon lambda t) by hand at t = 2.5 T."""
    error = estimates(SWUNG, 0.01, {"x": (-3.0, 3.0)}, period=TURN)
    assert error.periodic_bound(2.5 * TURN) == approx(2 * 2 * 6 * 1e-4 * TURN**2 * 3 * math.exp(0.02 * 2.5 * TURN), rel=1e-9)


def test_within_a_period_3_13_as_printed_is_no_bound():
    """x' = epsilon cos t has lambda = 0: the error epsilon sin t is bounded by delta alone."""
    error = estimates(System((x,), (epsilon * sp.cos(TIME),), (epsilon,)), 0.01, {"x": (0.0, 1.0)}, period=TURN)
    assert error.periodic_bound(math.pi / 2) == 0
    assert error.error_bound(math.pi / 2) == approx(0.01, rel=1e-7)


def _van_der_pol():
    given = System((x, v), (v, -x + epsilon * (1 - x**2) * v), (epsilon,))
    return with_amplitude_and_phase(given, x, v, sp.S.One, r, psi)


@mark.parametrize("small", [0.005, 0.02])
@mark.parametrize("name", ["swung", "van der Pol"])
def test_true_errors_are_below_the_bounds(name, small):
    """At whole periods (3.13) as printed, everywhere with delta; the states stay in the box over 0 <= t <= 1/epsilon."""
    system, start, box = {
        "swung": (SWUNG, [1.0], {"x": (0.0, 1.1)}),
        "van der Pol": (_van_der_pol(), [1.0, 0.0], {"r": (0.9, 1.6), "psi": (-0.2, 0.2)}),
    }[name]
    averaging = averaged(system, epsilon)
    period = float(averaging.period)
    slow = averaging.system
    numbers = averaging_error(system, slow, "epsilon", {"epsilon": small}, box, period)
    whole = np.arange(1, math.floor(1 / small / period) + 1) * period
    time = np.unique(np.concatenate([np.linspace(0, 1 / small, 500), whole[whole <= 1 / small]]))
    true, near = (_run(s, small, start, time) for s in (system, slow))
    low, high = np.array([box[n] for n in system.state_names]).T
    assert (np.clip(true.T, low, high) == true.T).all()
    error = np.linalg.norm(true - near, axis=0)
    assert (error <= numbers.error_bound(time)).all()
    at = np.isin(time, whole)
    assert at.sum() > 5
    assert (error[at] <= numbers.periodic_bound(time[at])).all()


def _run(system, small, start, time):
    rates = sp.lambdify((TIME, system.states, epsilon), [system.explicit(f) for f in system.derivatives], "math")
    return solve_ivp(rates, (0, time[-1]), start, "DOP853", t_eval=time, args=(small,), rtol=1e-12, atol=1e-12).y


def test_without_a_period_delta_is_taken_over_the_whole_time():
    """cos t + cos(sqrt(2) t): the largest |sin t + sin(sqrt(2) t)/sqrt(2)| up to t = 100."""
    system = System((x,), (epsilon * (sp.cos(TIME) + sp.cos(sp.sqrt(2) * TIME)),), (epsilon,))
    error = estimates(system, 0.01, {"x": (0.0, 1.0)}, points=2)
    time = np.linspace(0, 100, 100_001)
    assert error.delta == approx(
        0.01 * np.abs(np.sin(time) + np.sin(math.sqrt(2) * time) / math.sqrt(2)).max(), rel=1e-4
    )  # (2/128)^2/8 at a maximum
    with rejected("no-period"):
        error.periodic_bound(1.0)


def test_refusals():
    good = {"x": (0.0, 1.0)}
    slow = averaged(SWUNG, epsilon).system
    with rejected("no-limits", "x"):
        averaging_error(SWUNG, slow, "epsilon", {"epsilon": 0.1}, {})
    with rejected("epsilon"):
        averaging_error(SWUNG, slow, "epsilon", {"epsilon": 0.0}, good)
    with rejected("epsilon"):
        averaging_error(SWUNG, slow, "mu", {"epsilon": 0.1, "mu": 1.0}, good)
    with rejected("no-value"):
        averaging_error(SWUNG, slow, "epsilon", {}, good)
    singular = System((x,), (epsilon * sp.cos(TIME) / x,), (epsilon,))
    with rejected("not-finite", "x", "0.0"):
        estimates(singular, 0.1, good, period=TURN)


@mark.parametrize(
    ("name", "value"),
    [
        ("period", 0.0),
        ("period", -1.0),
        ("length", 0.0),
        ("points", 0),
        ("steps", -4),
        ("length", math.inf),
        ("period", math.nan),
    ],
)
def test_what_must_be_positive(name, value):
    with raises(WuchtError, match=f"the {name} must be positive and finite, not"):
        estimates(SWUNG, 0.1, {"x": (0.0, 1.0)}, **{name: value})


def test_a_right_hand_side_that_is_not_finite_at_some_times_is_refused():
    """1/(1 - x cos t) at x = 1: only where the cosine is 1, of all times."""
    pole = System((x,), (epsilon / (1 - x * sp.cos(TIME)),), (epsilon,))
    mean = System((x,), (epsilon * x,), (epsilon,))
    with rejected("not-finite", "x", "1.0"):
        averaging_error(pole, mean, "epsilon", {"epsilon": 0.1}, {"x": (0.5, 1.0)}, period=TURN)
