"""The optimum of the damping, 000 section 6, against (32)-(33) linearised by hand, and against what the paper says in words."""

from __future__ import annotations

import numpy as np
import pytest

from wucht import OptimiseBalancer, SynchronousStates, load_machine
from wucht import run as ask
from wucht.dynamics.balancers.candidates import evaluate_candidates
from wucht.dynamics.balancers.damping_optimum import compensated_state, damping_curve, decay_rate, decay_rates
from wucht.dynamics.work import Work

MACHINE = load_machine("sperling-rollers/figure-9")
RANGE = [5e-6, 5e-4]


def _by_hand(damping: float) -> np.ndarray:
    """The eigenvalues of (32)-(33) with c = 0, linearised about the compensating phases, from the numbers of section 6."""
    m, w, kx, ky, own = 1.0, 300.0, 3906.25, 15650.01, 1e-4
    u = np.array([1.2e-4, 0.8e-4])
    inertia = 1.4 * 1e-3 * (u / 1e-3) ** 2  # (7): (1 + mu) m eps^2, balls of 1 g
    a = 1 / (kx - m * w**2) + 1 / (ky - m * w**2)
    c1 = (u[1] ** 2 - own**2 - u[0] ** 2) / (2 * own * u[0])  # the triangle of the three forces
    c2 = (u[0] ** 2 - own**2 - u[1] ** 2) / (2 * own * u[1])
    alpha = np.array([np.arccos(c1), -np.arccos(c2)])
    k = np.empty((2, 2))
    for i in range(2):
        j = 1 - i
        both = u[j] * np.cos(alpha[i] - alpha[j])
        k[i, i], k[i, j] = own * np.cos(alpha[i]) + both, -both
        k[i] *= 0.5 * a * u[i] * w**4
    inverse = np.diag(1 / inertia)
    return np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ k, -damping * inverse]]))


@pytest.mark.parametrize("damping", [5e-6, 5e-5, 1.2e-4, 3e-4])
def test_rates_are_those_of_the_papers_equations(damping: float) -> None:
    changed = MACHINE.with_values({"r1.damping": damping, "r2.damping": damping})
    assert decay_rate(changed) == pytest.approx(-_by_hand(damping).real.max(), rel=0.03)


@pytest.mark.slow
def test_optimum_between_oscillation_and_creep() -> None:
    """Below it the slowest motion swings, above it creeps; runs from random starts take longer at either side."""
    spec = OptimiseBalancer(vary={"damping": RANGE}, samples=16, population=4, evaluations=4, seed=3)
    search, _ = spec.prepare(MACHINE)
    assert search.curve is not None
    trials, dampings = search.curve
    seen = evaluate_candidates(trials, "full", dampings[::6, None], Work(), "")
    curve = damping_curve(dampings[::6], seen, decay_rates(trials, dampings[::6]))
    assert dampings[0] == pytest.approx(RANGE[0])
    assert dampings[-1] == pytest.approx(RANGE[1])
    fine = np.geomspace(*RANGE, 4001)
    by_hand = fine[np.argmax([-_by_hand(b).real.max() for b in fine])]
    assert curve.rate_optimum == pytest.approx(by_hand, rel=0.03)
    slowest = [max(_by_hand(b), key=lambda e: e.real) for b in (0.8 * by_hand, 1.25 * by_hand)]
    assert abs(slowest[0].imag) > 1e-6
    assert abs(slowest[1].imag) < 1e-9
    assert 0.6 * by_hand < curve.optimum < 1.5 * by_hand
    assert np.all(curve.share_through == 1)
    decayed = [np.log(100) / -_by_hand(b).real.max() for b in curve.damping]
    assert curve.settling_time == pytest.approx(decayed, rel=0.2), "runs end as the linearised equations do: to 1 %"
    assert curve.settling_time[[0, -1]].min() > 2 * curve.settling_time.min()


def test_far_above_the_resonances_the_speed_matters_to_creep_alone() -> None:
    """000, section 6: the time is then nearly independent of the speed. So it is of oscillations; that of creep is not."""
    slow, fast = (MACHINE.with_values({"drive.speed": w}) for w in (1000.0, 2000.0))
    light, heavy = ({f"{b}.damping": x for b in ("r1", "r2")} for x in (1e-5, 5e-2))
    assert decay_rate(fast.with_values(light)) == pytest.approx(decay_rate(slow.with_values(light)), rel=1e-3)
    assert decay_rate(fast.with_values(heavy)) == pytest.approx(4 * decay_rate(slow.with_values(heavy)), rel=0.05)


@pytest.mark.parametrize("share", [1.0, 2.5])
def test_what_stands_is_what_synchronous_states_has(share: float) -> None:
    machine = MACHINE.with_values({"drum.unbalance": share * 1e-4})
    states = ask(SynchronousStates(), machine).wucht.summary["states"]
    stable = [s["residual_unbalance"] for s in states if s["stable_full"]]
    state = compensated_state(machine, full=True)
    assert state is not None
    assert state.residual == pytest.approx(min(stable), abs=1e-15)
    assert state.residual == pytest.approx(max(share * 1e-4 - 2e-4, 0.0), rel=1e-4), "the paper has no vibration damping"


def test_below_the_resonance_nothing_stands_that_balances() -> None:
    """000, section 5: there bodies add to the unbalance."""
    state = compensated_state(MACHINE.with_values({"drive.speed": 40.0}), full=True)
    assert state is not None
    assert state.residual == pytest.approx(3e-4, rel=1e-4)
