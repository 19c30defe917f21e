"""The band of existence: between which values the averaged equations have a stable motion in which rotors are taken along."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.studies.entrainment.averaged_equations import AveragedEquations
from wucht.studies.entrainment.branches import Branch, Continuation, StableRange
from wucht.studies.entrainment.prepare import Plan
from wucht.studies.entrainment.runs import RunFromStart
from wucht.studies.entrainment.swept_parameter import AMPLITUDE, DETUNING, no_load_speed, swept_parameter
from wucht.studies.work import Work

_MARGIN = 0.2  # of the band of existence: how far beyond it is looked
_FIRST, _LARGEST = 0.5, 3.0  # of the threshold, times it or the machine's own amplitude: where more only helps
_DOUBLINGS = 8
_GRID = 9  # values of a given range at which equilibria are looked for


@dataclass(frozen=True)
class Existence:
    """What the averaged equations say. band: the stable range that the question is about; equilibrium: the state (n,) on it,
    at the machine's own value or the nearest one well inside."""

    equations: AveragedEquations
    branches: tuple[Branch, ...]
    band: StableRange | None
    equilibrium: np.ndarray | None

    def contains(self, value: float) -> bool:
        """Whether a value lies in the band."""
        return self.band is not None and self.band.low.value < value < self.band.high.value

    @property
    def slowest_rate(self) -> float | None:
        """At which the slowest disturbance decays (1/time), None without a band."""
        if self.band is None or self.equilibrium is None:
            return None
        value = _well_inside(self.band, self.equations.swept.own)
        return -float(self.equations.eigenvalues(self.equilibrium, value).real.max())

    @property
    def phases(self) -> dict[str, float]:
        """The phases at the equilibrium by body, if the machine's own value lies in the band."""
        if self.equilibrium is None or not self.contains(self.equations.swept.own):
            return {}
        return {name: float(self.equilibrium[row]) for name, row in self.equations.phase_rows.items()}


def existence(plan: Plan, own: RunFromStart, senses: Mapping[str, float], work: Work) -> Existence:
    """Follow all equilibria, and choose the band. own: the run of the machine as it is. senses: +-1 a body.

    Raises ``InputError`` where the machine has no averaged equations.
    """
    equations = AveragedEquations.of(plan.steady, plan.swept, senses, plan.limits)
    seen = None
    if own.entrained:
        seen = equations.state_at(plan.machine, own.end_time, own.end_state, abs(own.mean_speed))
    continuation = Continuation(equations)
    values = _values(plan, senses)
    branches = continuation.branches(values, None if seen is None else seen[:, None], work)
    ranges = work.unit("stable ranges", lambda: continuation.stable_ranges(branches))
    band = _chosen(equations, branches, ranges, seen)
    return Existence(equations, branches, band, None if band is None else _equilibrium(equations, branches, band))


def _values(plan: Plan, senses: Mapping[str, float]) -> list[float]:
    """Where equilibria are looked for: at the machine's own value, and where nothing must be taken along by force."""
    machine, swept = plan.machine, plan.swept
    values, paths = [swept.own], {no_load_speed(machine, r): r for r in machine.rotors}
    if swept.name == DETUNING:
        values.append(0.0)
    elif swept.name == AMPLITUDE:
        values += [swept.own * 2.0**k for k in range(1, 4)]
    elif swept.name in paths:
        frequency = machine.shaking_frequency
        mine = paths[swept.name] if frequency is None else machine.rotor
        others = [abs(machine.values[p]) for p, r in paths.items() if p is not None and r is not mine]
        equal = frequency or (float(np.mean(others)) if others else abs(swept.own))
        values.append(senses[mine.name] * equal)
    if plan.range is not None:
        values += np.linspace(*plan.limits, _GRID).tolist()
    return [v for v in dict.fromkeys(values) if plan.limits[0] <= v <= plan.limits[1]]


def _chosen(
    equations: AveragedEquations, branches: tuple[Branch, ...], ranges: tuple[StableRange, ...], seen: np.ndarray | None
) -> StableRange | None:
    """The range in which the machine is; else that which is nearest, and of several the widest. seen: the machine's state."""
    own = equations.swept.own

    def order(r: StableRange) -> tuple[float, float, float]:
        away = max(r.low.value - own, own - r.high.value, 0.0)
        apart = 0.0 if seen is None else equations.distance(_nearest(branches, r, own), seen)
        return away, round(apart, 3), r.low.value - r.high.value

    return min(ranges, key=order, default=None)


def _nearest(branches: tuple[Branch, ...], band: StableRange, value: float) -> np.ndarray:
    """The state (n,) of the point in a range that is nearest to a value."""
    b = branches[band.branch]
    return b.states[:, int(band.points[np.abs(b.values[band.points] - value).argmin()])]


def _equilibrium(equations: AveragedEquations, branches: tuple[Branch, ...], band: StableRange) -> np.ndarray:
    near = _nearest(branches, band, equations.swept.own)
    value = _well_inside(band, equations.swept.own)
    stable = [s for s in equations.equilibria(value, near[:, None]) if equations.stable(s, value)]
    return min(stable, key=lambda s: equations.distance(s, near), default=near)


def _well_inside(band: StableRange, value: float) -> float:
    """A value, or the nearest one well inside the band."""
    if band.low.value < value < band.high.value:
        return value
    width = band.high.value - band.low.value
    return float(np.clip(value, band.low.value + 0.1 * width, band.high.value - 0.1 * width))


def range_around(plan: Plan, band: StableRange | None) -> tuple[float, float]:
    """The range to be looked at where none is given: the band of existence and a margin, the machine's own value included."""
    own, (least, most) = plan.swept.own, plan.limits
    if band is None:
        reach = max(abs(own), (most - least) / 100)
        return max(own - reach, least), min(own + reach, most)
    if plan.swept.name == AMPLITUDE:
        return _FIRST * band.low.value, _LARGEST * max(own, band.low.value if band.low.kind != "range" else 0.0)
    ends = [band.low.value, band.high.value, own]
    margin = _MARGIN * (max(ends) - min(ends))
    return max(min(ends) - margin, least), min(max(ends) + margin, most)


def threshold(plan: Plan, existing: Existence | None, work: Work) -> float | None:
    """The least amplitude of the vibration that takes the main rotor along against its drive and its bearing: 001 (25)."""
    if existing is None or plan.machine.shaken is None:
        return None
    if plan.swept.name == AMPLITUDE:
        return existing.band.low.value if existing.band is not None and existing.band.low.kind != "range" else None
    amplitude = swept_parameter(plan.steady, AMPLITUDE)
    for k in range(_DOUBLINGS if amplitude.own > 0 else 0):
        largest = amplitude.own * 2.0**k
        continuation = Continuation(AveragedEquations(existing.equations.averaged, amplitude, (0.0, largest * 1.001)))
        branches = continuation.branches([largest], None, work.part(f"amplitude {k}", k / _DOUBLINGS, (k + 1) / _DOUBLINGS))
        reached = [r.low.value for r in continuation.stable_ranges(branches) if r.high.kind == "range"]
        if reached:
            return min(reached)
    return None
