"""The band of existence: between which values the averaged equations have a stable motion in which rotors are entrained."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.dynamics.entrainment.averaged_equations import AveragedEquations
from wucht.dynamics.entrainment.branches import Branch, Continuation, StableRange
from wucht.dynamics.entrainment.entrainment_case import AMPLITUDE, DETUNING, EntrainmentCase, no_load_speed, swept_parameter
from wucht.dynamics.entrainment.runs_from_start import RunFromStart
from wucht.dynamics.work import Work

_MARGIN = 0.2  # of the band of existence: how far beyond it is looked
_FIRST, _LARGEST = 0.5, 3.0  # of the threshold, times it or the machine's own amplitude: where more only helps
_DOUBLINGS = 8
_GRID = 9  # values of a given range at which equilibria are looked for


@dataclass(frozen=True)
class Existence:
    """What the averaged equations answer: nothing where there are none. band: the stable range that the question is about.

    slowest_rate: at which the slowest disturbance decays in it (1/time), at the machine's own value or the nearest one well
    inside. phases: there by body, if the machine's own value lies in the band. warnings: what is left out.
    """

    equations: AveragedEquations | None = None
    warnings: tuple[str, ...] = ()
    branches: tuple[Branch, ...] = ()
    band: StableRange | None = None
    slowest_rate: float | None = None
    phases: Mapping[str, float] = field(default_factory=dict)


def existence(case: EntrainmentCase, own: RunFromStart, senses: Mapping[str, float], work: Work) -> Existence:
    """Follow all equilibria, and choose the band. own: the run of the machine as it is. senses: +-1 a body.

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
        """The state (n,) of the point in a range that is nearest to the own value."""
        b = branches[r.branch]
        return b.states[:, int(r.points[np.abs(b.values[r.points] - value).argmin()])]

    def order(r: StableRange) -> tuple[float, float, float]:
        """The range in which the machine is; else that which is nearest, and of several the widest."""
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
    """Where equilibria are looked for: at the machine's own value, and where no torque is needed for entrainment."""
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
    """The range to be looked at where none is given: the band of existence and a margin, the machine's own value included."""
    own, (least, most) = case.swept.own, case.limits
    if band is not None and case.swept.name == AMPLITUDE:
        return _FIRST * band.low.value, _LARGEST * max(own, band.low.value if band.low.kind != "range" else 0.0)
    ends = [own] if band is None else [band.low.value, band.high.value, own]
    margin = max(abs(own), (most - least) / 100) if band is None else _MARGIN * (max(ends) - min(ends))
    return max(min(ends) - margin, least), min(max(ends) + margin, most)


def threshold(case: EntrainmentCase, existing: Existence, work: Work) -> float | None:
    """The least amplitude of the vibration that entrains the main rotor against its drive and its bearing: 001 (25)."""
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
