"""Damping between oscillation and creep: 000, section 6. Small damping lets bodies swing about their places for long, large
damping lets them creep there; between them lies the damping with the shortest settling time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.configuration import Configuration, ConfigurationDescriber
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.search import all_states
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.vibration import Vibration
from wucht.dynamics.balancers.candidates import CAPTURE, SETTLING, BalancerTrials, CandidateResults
from wucht.dynamics.sampling.searches import Variable, balancer_names
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import driven_speeds, machine_at_speed

_CURVE = 25  # dampings
_DECADES = 1.5  # on either side of the machine's damping, where it is not varied


def states_at_speed(machine: Machine) -> tuple[State, ...]:
    """Return the steady states of ``synchronous-states`` above the resonance, or at the prescribed speed, stable or not.

    They do not depend on the damping between the bodies and the rotor: there is no relative motion. Raises ``InputError`` for
    a machine without averaged equations.
    """
    steady = machine_at_speed(machine, None)
    torques = SteadyTorques.from_averaged_equations(averaged_equations_of(steady, True))
    low, high = driven_speeds(steady)[0] if torques.fixed_speed is None else (0.0, 0.0)
    candidates = tuple(all_states(torques, low, high).states)
    if torques.fixed_speed is not None:
        return candidates
    index = [steady.bodies.index(b) for b in steady.group(steady.rotor)]
    vibration = Vibration.of(steady).select_bodies(index)
    resonances = [vibration.last_maximum(high, s.phases[index]) for s in candidates]
    return tuple(s for s, resonance in zip(candidates, resonances, strict=True) if resonance is None or s.speed > resonance)


def compensated_state(machine: Machine, full: bool, states: Sequence[State] | None = None) -> Configuration | None:
    """Return the stable one of these states that leaves least unbalance; None if there is none.

    full: by the full equations, else by the averaged ones with the inertia of the bodies. states: if already computed. Raises
    ``InputError`` for a machine without averaged equations.
    """
    averaged_equations = averaged_equations_of(machine_at_speed(machine, None), True)
    torques = SteadyTorques.from_averaged_equations(averaged_equations)
    describer = ConfigurationDescriber(AveragedStability(torques, averaged_equations))
    judge = FullStability(torques, True)
    candidates = states_at_speed(machine) if states is None else states
    descriptions = [(s, describer.describe(s, describer.averaged_stability.stability(s))) for s in candidates]
    descriptions = [(s, c) for s, c in descriptions if c.residual is not None and c.slow.stable is not False]
    for state, configuration in sorted(descriptions, key=lambda one: one[1].residual or 0.0):
        stable = (judge.stability(state) if full else configuration.slow).stable
        if stable:
            return configuration
    return None


def decay_rate(machine: Machine, states: Sequence[State] | None = None) -> float:
    """Return the slowest decay rate of small deviations from that state in the averaged equations; nan where there is none."""
    state = compensated_state(machine, full=False, states=states)
    return np.nan if state is None or state.slow.leading is None else -state.slow.leading.real


@dataclass(frozen=True)
class DampingCurve:
    """Median settling time over the damping (N,) of the bodies, the share of the runs that pass the resonance, and the slowest
    rate at which small deviations decay. optimum: the damping of the shortest settling time; rate_optimum: that of the
    greatest rate."""

    damping: np.ndarray
    settling_time: np.ndarray
    share_through: np.ndarray
    rate: np.ndarray
    optimum: float
    rate_optimum: float


def curve_trials(trials: BalancerTrials) -> tuple[BalancerTrials, np.ndarray] | None:
    """Return trials with the damping of all bodies as the only variable, and the dampings (N,); None where a body has none."""
    machine, names = trials.machine, balancer_names(trials.machine)
    if any(f"{b}.damping" not in machine.values for b in names):
        return None
    damping_variable = next((v for v in trials.variables if v.key == "damping" and len(v.paths) == len(names)), None)
    damping = max(machine.values[f"{b}.damping"] for b in names)
    if damping_variable is None and not damping > 0:
        return None
    low, high = (
        (damping * 10**-_DECADES, damping * 10**_DECADES)
        if damping_variable is None
        else (damping_variable.low, damping_variable.high)
    )
    if not low > 0:
        low = high * 10 ** (-2 * _DECADES)
    parameter = machine.parameters[f"{names[0]}.damping"]
    only = Variable("damping", "damping", tuple(f"{b}.damping" for b in names), low, high, parameter.unit, parameter.long_name)
    return replace(trials, variables=(only,)), np.geomspace(low, high, _CURVE)


def damping_curve(dampings: np.ndarray, results: CandidateResults, rates: tuple[np.ndarray, float]) -> DampingCurve:
    """Return the curve from the runs of a machine with the dampings (N,); rates: see ``decay_rates``."""
    settling, through = results.objectives[:, SETTLING], 1 - results.objectives[:, CAPTURE]
    # Settling times of the few runs that pass are not representative.
    most = np.where(through >= through.max(), settling, np.nan)
    optimum = float(dampings[np.nanargmin(most)]) if np.isfinite(most).any() else np.nan
    return DampingCurve(dampings, settling, through, rates[0], optimum, rates[1])


def decay_rates(trials: BalancerTrials, dampings: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the slowest decay rates (N,) of small deviations, and the damping where they are greatest.

    They are of the linearised averaged equations, nan without these. dampings (N,): the only variable of ``trials``.
    """
    try:
        states = states_at_speed(trials.machine)
    except InputError:
        return np.full(len(dampings), np.nan), np.nan

    def rate(damping: float) -> float:
        return decay_rate(trials.candidate_machine([damping]), states)

    rates = np.array([rate(b) for b in dampings.tolist()])
    return rates, _damping_of_fastest_decay(rate, dampings, rates)


def _damping_of_fastest_decay(rate: Callable[[float], float], dampings: np.ndarray, rates: np.ndarray) -> float:
    """Return the damping of the greatest rate: the curve has a corner there, so it is bracketed, not interpolated."""
    from scipy.optimize import minimize_scalar

    if not np.isfinite(rates).any():
        return np.nan
    k = int(np.nanargmax(rates))
    if k in (0, len(rates) - 1):
        return float(dampings[k])
    ends = np.log(dampings[[k - 1, k + 1]])
    solution = minimize_scalar(lambda x: -rate(float(np.exp(x))), bounds=tuple(ends), method="bounded", options={"xatol": 1e-3})
    return float(np.exp(solution.x))
