"""Band of existence: values between which the averaged equations have a stable motion in which rotors are entrained."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.dynamics.entrainment.averaged_equations import STABLE, AveragedEquations
from wucht.dynamics.entrainment.entrainment_case import (
    AMPLITUDE,
    DETUNING,
    EntrainmentCase,
    no_load_speed,
    swept_parameter,
)
from wucht.dynamics.entrainment.runs_from_start import RunFromStart
from wucht.dynamics.work import Work
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equilibria import FOLD, HOPF, Equilibria
from wucht.numerics.continuation.fold_curves import direction
from wucht.numerics.zeros_and_peaks import stretches

STEP = 0.05  # of the arc length: phases in rad, speeds and the parameter by their sizes
_STEPS = Steps(first=STEP, most=2 * STEP, points=4000)
_ANYWHERE = 64  # starts of the search for an equilibrium at any value
RANGE = "range"


@dataclass(frozen=True)
class Branch:
    """Equilibria along their arc length.

    values: (N,) of the parameter. states: (n, N). stable: (N,), at a special point as beside it on the stable side. kinds (N):
    "" or the kind of a special point. leaving (N): the complex exponent that grows fastest. closed: it returns.
    """

    values: np.ndarray
    states: np.ndarray
    stable: np.ndarray
    kinds: tuple[str, ...]
    leaving: np.ndarray
    closed: bool


@dataclass(frozen=True)
class Edge:
    """End of stability: the value of the parameter, and its kind: ``fold``, ``hopf``, ``branch-point``, or ``range`` where the
    range ends.
    """

    value: float
    kind: str


@dataclass(frozen=True)
class StableRange:
    """Stable stretch of a branch, from ``low`` to ``high``; points: indices into the branch."""

    branch: int
    low: Edge
    high: Edge
    points: np.ndarray


class Continuation:
    """Continuation of equilibria of averaged equations with the parameter."""

    def __init__(self, equations: AveragedEquations) -> None:
        self.equations = equations
        turning = dict.fromkeys(np.flatnonzero(~equations.phases).tolist(), (0.0, math.inf))
        self.problem = Equilibria(equations.equations, equations.limits, _STEPS, turning)

    def branches(self, values: Sequence[float], more: np.ndarray | None, work: Work) -> tuple[Branch, ...]:
        """Follow all branches through the values, from many starts there and from states ``more`` (n, N) at the first."""
        branches: list[Branch] = []

        def follow(state: np.ndarray, value: float, share: float) -> None:
            work.report(share, "averaged equations")
            if not any(self.passes(b, state, value) for b in branches):
                branches.append(work.unit(f"branch {len(branches)}", partial(self.branch, state, value)))

        for i, value in enumerate(values):
            for state in work.unit(f"equilibria at {value!r}", partial(self.equations.equilibria, value, None if i else more)):
                follow(state, value, i / len(values))
        for state, value in () if branches else work.unit("equilibria anywhere", partial(self._anywhere, values[0])):
            follow(state, value, 1.0)
        work.report(1.0, "averaged equations")
        return tuple(branches)

    def branch(self, state: np.ndarray, value: float) -> Branch:
        """Follow the branch through an equilibrium both ways, up to the limits or until it closes."""
        at, e = np.append(state, value), self.problem.equations
        whole = self.problem.branch(self.problem.curve.start(at, direction(e.values(at)[1], e.scale)))
        exponents = np.array([p.eigenvalues for p in whole.points])
        decays = exponents.real.max(axis=1) < -STABLE * np.abs(exponents).max(axis=1)
        special = np.array([bool(p.kind) for p in whole.points])
        beside = np.append(False, decays[:-1] & ~special[:-1]) | np.append(decays[1:] & ~special[1:], False)
        leaving = np.take_along_axis(exponents, exponents.real.argmax(axis=1)[:, None], axis=1)[:, 0]
        kinds, stable = tuple(p.kind for p in whole.points), np.where(special, beside, decays)
        return Branch(whole.u[-1], whole.u[:-1], stable, kinds, leaving, whole.closed)

    def passes(self, branch: Branch, state: np.ndarray, value: float) -> bool:
        """True if an equilibrium lies on a branch."""
        v, states = branch.values, branch.states.T
        k = np.flatnonzero((np.minimum(v[1:], v[:-1]) <= value) & (value <= np.maximum(v[1:], v[:-1])))
        width = v[k + 1] - v[k]
        share = np.divide(value - v[k], width, out=np.zeros(len(k)), where=width != 0)
        between = states[k] + share[:, None] * (states[k + 1] - states[k])
        return bool((self.equations.distance(between, state) < STEP).any())

    def stable_ranges(self, branches: Sequence[Branch]) -> tuple[StableRange, ...]:
        """Return all stable stretches."""
        ranges = []
        for index, b in enumerate(branches):
            regular = np.flatnonzero([not kind for kind in b.kinds])
            stable = b.stable[regular]
            if b.closed and not stable.all():  # begin where it is not stable, so that no stretch is cut
                first = int(np.flatnonzero(~stable)[0])
                regular = np.concatenate([regular[first:-1], regular[: first + 1]])  # its last point is its first
                stable = b.stable[regular]
            for begin, end in stretches(stable):
                before = regular[begin - 1] if begin else None
                after = regular[end] if end < len(regular) else None
                ends = _edge(b, regular[begin], before), _edge(b, regular[end - 1], after)
                low, high = sorted(ends, key=lambda e: e.value)
                ranges.append(StableRange(index, low, high, regular[begin:end]))
        return tuple(ranges)

    def _anywhere(self, value: float) -> list[tuple[np.ndarray, float]]:
        """Search equilibria at any other values: one phase is held, and the value that it needs is solved for."""
        e, (low, high) = self.equations, self.equations.limits
        states, values = e.with_a_phase_held(e.starts()[:, :_ANYWHERE], value)
        return [(e.wrapped(x), float(v)) for x, v in zip(states.T, values, strict=True) if low <= v <= high and e.turning(x)]


def _edge(b: Branch, inside: int, outside: int | None) -> Edge:
    """Return where stability is lost between a stable point and its neighbour: at the special point between them."""
    if outside is None:
        return Edge(float(b.values[inside]), RANGE)
    forward = (outside - inside) % len(b.values) <= len(b.values) // 2 if b.closed else outside > inside
    step = 1 if forward else -1
    beside = (inside + step) % len(b.values)
    if kind := b.kinds[beside]:
        return Edge(float(b.values[beside]), kind)
    # No special point was located between them.
    return Edge(float(b.values[inside]), HOPF if b.leaving[outside].imag else FOLD)


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

    equations: AveragedEquations | None = None
    warnings: tuple[str, ...] = ()
    branches: tuple[Branch, ...] = ()
    band: StableRange | None = None
    slowest_rate: float | None = None
    phases: Mapping[str, float] = field(default_factory=dict)


def existence(case: EntrainmentCase, own: RunFromStart, senses: Mapping[str, float], work: Work) -> Existence:
    """Follow all equilibria, and choose the band. nominal_run: of the unchanged machine. senses: +-1 per body.

    Raises ``InputError`` where the machine has no averaged equations.
    """
    equations, value = AveragedEquations(case.steady, case.swept, senses, case.limits), case.swept.own
    reached = None
    if own.entrained:
        reached = equations.state_at(case.machine, own.end_time, own.end_state, abs(own.mean_speed))
    continuation = Continuation(equations)
    branches = continuation.branches(_values(case, senses), None if reached is None else reached[:, None], work)
    ranges = work.unit("stable ranges", lambda: continuation.stable_ranges(branches))

    def nearest(r: StableRange) -> np.ndarray:
        """Return the state (n,) of the point in a range that is nearest to the nominal value."""
        b = branches[r.branch]
        return b.states[:, int(r.points[np.abs(b.values[r.points] - value).argmin()])]

    def order(r: StableRange) -> tuple[float, float, float]:
        """Return the sorting key: first the range of the machine; else the nearest one, and of several the widest."""
        away = max(r.low.value - value, value - r.high.value, 0.0)
        apart = 0.0 if reached is None else float(equations.distance(nearest(r), reached))
        return away, round(apart, 3), r.low.value - r.high.value

    existing = Existence(equations, equations.averaged.warnings, branches)
    if not ranges:
        return existing
    band = min(ranges, key=order)
    low, high, near = band.low.value, band.high.value, nearest(band)
    inside = low < value < high
    value_inside = value if inside else float(np.clip(value, low + 0.1 * (high - low), high - 0.1 * (high - low)))
    stable = [s for s in equations.equilibria(value_inside, near[:, None]) if equations.stable(s, value_inside)]
    state = min(stable, key=lambda s: equations.distance(s, near), default=near)
    phases = {name: float(state[row]) for name, row in equations.phase_rows.items()} if inside else {}
    rate = -float(equations.eigenvalues(state, value_inside).real.max())
    return replace(existing, band=band, slowest_rate=rate, phases=phases)


def _values(case: EntrainmentCase, senses: Mapping[str, float]) -> list[float]:
    """Return the values of the search for equilibria: the nominal one, and where entrainment needs no torque."""
    machine, swept = case.machine, case.swept
    values, paths = [swept.own], {no_load_speed(machine, r): r for r in machine.rotors}
    if swept.name == DETUNING:
        values.append(0.0)
    elif swept.name == AMPLITUDE:
        values += [swept.own * 2.0**k for k in range(1, 4)]
    elif swept.name in paths:
        frequency = machine.shaking_frequency
        rotor = paths[swept.name] if frequency is None else machine.rotor
        others = [abs(machine.values[p]) for p, r in paths.items() if p is not None and r is not rotor]
        equal = frequency or (float(np.mean(others)) if others else abs(swept.own))
        values.append(senses[rotor.name] * equal)
    if case.range is not None:
        values += np.linspace(*case.limits, _GRID).tolist()
    return [v for v in dict.fromkeys(values) if case.limits[0] <= v <= case.limits[1]]


def range_around(case: EntrainmentCase, band: StableRange | None) -> tuple[float, float]:
    """Return the range to examine where none is given: the band of existence and a margin, including the nominal value."""
    own, (least, most) = case.swept.own, case.limits
    if band is not None and case.swept.name == AMPLITUDE:
        return _FIRST * band.low.value, _LARGEST * max(own, band.low.value if band.low.kind != "range" else 0.0)
    ends = [own] if band is None else [band.low.value, band.high.value, own]
    margin = max(abs(own), (most - least) / 100) if band is None else _MARGIN * (max(ends) - min(ends))
    return max(min(ends) - margin, least), min(max(ends) + margin, most)


def threshold(case: EntrainmentCase, existing: Existence, work: Work) -> float | None:
    """Return the least amplitude of the vibration that entrains the main rotor against drive and bearing: 001 (25)."""
    if existing.equations is None or case.machine.shaken is None:
        return None
    if case.swept.name == AMPLITUDE:
        return existing.band.low.value if existing.band is not None and existing.band.low.kind != "range" else None
    amplitude, senses = swept_parameter(case.steady, AMPLITUDE), existing.equations.averaged.senses
    for k in range(_DOUBLINGS if amplitude.own > 0 else 0):
        largest = amplitude.own * 2.0**k
        continuation = Continuation(AveragedEquations(case.steady, amplitude, senses, (0.0, largest * 1.001)))
        branches = continuation.branches([largest], None, work.part(f"amplitude {k}", k / _DOUBLINGS, (k + 1) / _DOUBLINGS))
        reached = [r.low.value for r in continuation.stable_ranges(branches) if r.high.kind == "range"]
        if reached:
            return min(reached)
    return None
