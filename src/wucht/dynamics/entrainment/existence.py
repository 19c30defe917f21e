"""Band of existence: values between which the averaged equations have a stable motion in which rotors are entrained."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.entrainment.entrainment_case import (
    AMPLITUDE,
    DETUNING,
    EntrainmentCase,
    no_load_speed,
    swept_parameter,
)
from wucht.dynamics.entrainment.entrainment_equations import EntrainmentEquations
from wucht.dynamics.entrainment.runs_from_start import RunFromStart
from wucht.dynamics.work import Work
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equilibria import FOLD, HOPF, EquilibriumContinuation
from wucht.numerics.continuation.fold_curves import direction
from wucht.numerics.zeros_and_peaks import stretches

STEP = 0.05  # of the arc length: phases in rad, speeds and the parameter by their sizes
_STEPS = Steps(first=STEP, most=2 * STEP, points=4000)
_ANYWHERE = 64  # starts of the search for an equilibrium at any value
RANGE = "range"


@dataclass(frozen=True)
class StableRange:
    """Stable stretch of a branch. ends: values of the parameter at its lower and upper end. kinds: of these ends: ``fold``,
    ``hopf``, ``branch-point``, or ``range`` where the range ends. points: indices into the branch."""

    branch: int
    ends: tuple[float, float]
    kinds: tuple[str, str]
    points: np.ndarray


class Continuation:
    """Continuation of equilibria of averaged equations with the parameter."""

    def __init__(self, equations: EntrainmentEquations) -> None:
        self.equations = equations
        turning = dict.fromkeys(np.flatnonzero(~equations.phases).tolist(), (0.0, math.inf))
        self.problem = EquilibriumContinuation(equations.equations, equations.limits, _STEPS, turning)

    def branches(self, values: Sequence[float], more: np.ndarray | None, work: Work) -> tuple[EquilibriumBranch, ...]:
        """Follow all branches through the values, from many starts there and from states ``more`` (n, N) at the first."""
        branches: list[EquilibriumBranch] = []

        def follow(state: np.ndarray, value: float, share: float) -> None:
            work.report(share, "averaged equations")
            if not any(self.passes(b, state, value) for b in branches):
                branches.append(work.unit(f"branch {len(branches)}", partial(self.follow_branch, state, value)))

        for i, value in enumerate(values):
            for state in work.unit(f"equilibria at {value!r}", partial(self.equations.equilibria, value, None if i else more)):
                follow(state, value, i / len(values))
        for state, value in () if branches else work.unit("equilibria anywhere", partial(self._equilibria_anywhere, values[0])):
            follow(state, value, 1.0)
        work.report(1.0, "averaged equations")
        return tuple(branches)

    def follow_branch(self, state: np.ndarray, value: float) -> EquilibriumBranch:
        """Follow the branch through an equilibrium both ways, up to the limits or until it closes."""
        at, e = np.append(state, value), self.problem.equations
        whole = self.problem.follow_branch(self.problem.curve.start(at, direction(e.values(at)[1], e.scale)))
        exponents = np.array([p.eigenvalues for p in whole.points]).T
        return EquilibriumBranch(whole.unknowns, exponents, tuple(p.kind for p in whole.points), whole.ends)

    def passes(self, branch: EquilibriumBranch, state: np.ndarray, value: float) -> bool:
        """True if an equilibrium lies on a branch."""
        v, states = branch.parameter_values, branch.unknowns[:-1].T
        k = np.flatnonzero((np.minimum(v[1:], v[:-1]) <= value) & (value <= np.maximum(v[1:], v[:-1])))
        width = v[k + 1] - v[k]
        share = np.divide(value - v[k], width, out=np.zeros(len(k)), where=width != 0)
        between = states[k] + share[:, None] * (states[k + 1] - states[k])
        return bool((self.equations.distance(between, state) < STEP).any())

    def stable_ranges(self, branches: Sequence[EquilibriumBranch]) -> tuple[StableRange, ...]:
        """Return all stable stretches."""
        ranges = []
        for index, b in enumerate(branches):
            regular = np.flatnonzero([not kind for kind in b.kinds])
            stable = b.stable[regular]
            if b.is_closed and not stable.all():  # begin where it is not stable, so that no stretch is cut
                first = int(np.flatnonzero(~stable)[0])
                regular = np.concatenate([regular[first:-1], regular[: first + 1]])  # its last point is its first
                stable = b.stable[regular]
            for begin, end in stretches(stable):
                before = regular[begin - 1] if begin else None
                after = regular[end] if end < len(regular) else None
                edges = _edge(b, regular[begin], before), _edge(b, regular[end - 1], after)
                (low, low_kind), (high, high_kind) = sorted(edges, key=lambda edge: edge[0])
                ranges.append(StableRange(index, (low, high), (low_kind, high_kind), regular[begin:end]))
        return tuple(ranges)

    def _equilibria_anywhere(self, value: float) -> list[tuple[np.ndarray, float]]:
        """Search equilibria at any other values: one phase is held, and the value that it needs is solved for."""
        e, (low, high) = self.equations, self.equations.limits
        states, values = e.with_fixed_phase(e.starts()[:, :_ANYWHERE], value)
        return [
            (e.wrap_phases(x), float(v)) for x, v in zip(states.T, values, strict=True) if low <= v <= high and e.is_turning(x)
        ]


def _edge(b: EquilibriumBranch, inside: int, outside: int | None) -> tuple[float, str]:
    """Return where stability is lost between a stable point and its neighbour, at the special point between them; and its
    kind."""
    values = b.parameter_values.tolist()
    if outside is None:
        return values[inside], RANGE
    count = len(values) - b.is_closed  # the last point of a closed branch is its first
    forward = (outside - inside) % count <= count // 2 if b.is_closed else outside > inside
    step = 1 if forward else -1
    beside = (inside + step) % count
    if kind := b.kinds[beside]:
        return values[beside], kind
    # No special point was located between them.
    exponents = b.exponents[:, outside]
    return values[inside], HOPF if exponents[exponents.real.argmax()].imag else FOLD


_MARGIN = 0.2  # of the band of existence: margin of the examined range
_FIRST, _LARGEST = 0.5, 3.0  # of the threshold, times it or the nominal amplitude: range where a larger amplitude only helps
_DOUBLINGS = 8
_GRID = 9  # values of a given range at which equilibria are searched


@dataclass(frozen=True)
class Existence:
    """Result of the averaged equations, empty where there are none. band: the stable range of the machine, or nearest to it.

    slowest_rate: at which the slowest disturbance decays in it (1/time), at the nominal value or the nearest one well
    inside. phases: there by body, if the nominal value lies in the band. warnings: omissions.
    """

    equations: EntrainmentEquations | None = None
    warnings: tuple[str, ...] = ()
    branches: tuple[EquilibriumBranch, ...] = ()
    band: StableRange | None = None
    slowest_rate: float | None = None
    phases: Mapping[str, float] = field(default_factory=dict)


def existence(case: EntrainmentCase, nominal_run: RunFromStart, senses: Mapping[str, float], work: Work) -> Existence:
    """Follow all equilibria, and choose the band. nominal_run: of the unchanged machine. senses: +-1 per body.

    Raises ``InputError`` where the machine has no averaged equations.
    """
    equations, value = EntrainmentEquations(case.steady, case.parameter, senses, case.limits), case.parameter.nominal_value
    run_state = None
    if nominal_run.is_entrained:
        run_state = equations.state_at(case.machine, nominal_run.end_time, nominal_run.end_state, abs(nominal_run.mean_speed))
    continuation = Continuation(equations)
    branches = continuation.branches(_values(case, senses), None if run_state is None else run_state[:, None], work)
    ranges = work.unit("stable ranges", lambda: continuation.stable_ranges(branches))

    def nearest(r: StableRange) -> np.ndarray:
        """Return the state (n,) of the point in a range that is nearest to the nominal value."""
        b = branches[r.branch]
        return np.asarray(b.unknowns[:-1, int(r.points[np.abs(b.parameter_values[r.points] - value).argmin()])])

    def order(r: StableRange) -> tuple[float, float, float]:
        """Return the sorting key: first the range of the machine; else the nearest one, and of several the widest."""
        low, high = r.ends
        away = max(low - value, value - high, 0.0)
        apart = 0.0 if run_state is None else float(equations.distance(nearest(r), run_state))
        return away, round(apart, 3), low - high

    existing = Existence(equations, equations.averaged_equations.warnings, branches)
    if not ranges:
        return existing
    band = min(ranges, key=order)
    (low, high), near = band.ends, nearest(band)
    inside = low < value < high
    value_inside = value if inside else float(np.clip(value, low + 0.1 * (high - low), high - 0.1 * (high - low)))
    stable = [s for s in equations.equilibria(value_inside, near[:, None]) if equations.is_stable(s, value_inside)]
    state = min(stable, key=lambda s: equations.distance(s, near), default=near)
    phases = {name: float(state[row]) for name, row in equations.phase_rows.items()} if inside else {}
    rate = -float(equations.eigenvalues(state, value_inside).real.max())
    return replace(existing, band=band, slowest_rate=rate, phases=phases)


def _values(case: EntrainmentCase, senses: Mapping[str, float]) -> list[float]:
    """Return the values of the search for equilibria: the nominal one, and where entrainment needs no torque."""
    machine, parameter = case.machine, case.parameter
    values, paths = [parameter.nominal_value], {no_load_speed(machine, r): r for r in machine.rotors}
    if parameter.name == DETUNING:
        values.append(0.0)
    elif parameter.name == AMPLITUDE:
        values += [parameter.nominal_value * 2.0**k for k in range(1, 4)]
    elif parameter.name in paths:
        frequency = machine.shaking_frequency
        rotor = paths[parameter.name] if frequency is None else machine.rotor
        other_speeds = [abs(machine.values[p]) for p, r in paths.items() if p is not None and r is not rotor]
        equal = frequency or (float(np.mean(other_speeds)) if other_speeds else abs(parameter.nominal_value))
        values.append(senses[rotor.name] * equal)
    if case.range is not None:
        values += np.linspace(*case.limits, _GRID).tolist()
    return [v for v in dict.fromkeys(values) if case.limits[0] <= v <= case.limits[1]]


def range_around(case: EntrainmentCase, band: StableRange | None) -> tuple[float, float]:
    """Return the range to examine where none is given: the band of existence and a margin, including the nominal value."""
    nominal_value, (least, most) = case.parameter.nominal_value, case.limits
    if band is not None and case.parameter.name == AMPLITUDE:
        low = band.ends[0]
        return _FIRST * low, _LARGEST * max(nominal_value, 0.0 if band.kinds[0] == RANGE else low)
    ends = [nominal_value] if band is None else [*band.ends, nominal_value]
    margin = max(abs(nominal_value), (most - least) / 100) if band is None else _MARGIN * (max(ends) - min(ends))
    return max(min(ends) - margin, least), min(max(ends) + margin, most)


def threshold(case: EntrainmentCase, existing: Existence, work: Work) -> float | None:
    """Return the least amplitude of the vibration that entrains the main rotor against drive and bearing: 001 (25)."""
    if existing.equations is None or case.machine.shaken_coordinate is None:
        return None
    if case.parameter.name == AMPLITUDE:
        band = existing.band
        return None if band is None or band.kinds[0] == RANGE else band.ends[0]
    amplitude, senses = swept_parameter(case.steady, AMPLITUDE), existing.equations.averaged_equations.senses
    for k in range(_DOUBLINGS if amplitude.nominal_value > 0 else 0):
        largest = amplitude.nominal_value * 2.0**k
        continuation = Continuation(EntrainmentEquations(case.steady, amplitude, senses, (0.0, largest * 1.001)))
        branches = continuation.branches([largest], None, work.part(f"amplitude {k}", k / _DOUBLINGS, (k + 1) / _DOUBLINGS))
        least_amplitudes = [r.ends[0] for r in continuation.stable_ranges(branches) if r.kinds[1] == RANGE]
        if least_amplitudes:
            return min(least_amplitudes)
    return None
