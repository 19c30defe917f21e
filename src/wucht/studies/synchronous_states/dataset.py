"""Findings -> Dataset: the states with their stability, the stability map, and the summary."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.configurations.averaged_stability import REGIONS, Regions
from wucht.analysis.configurations.configuration import STABLE, STABLE_SLOW, UNDECIDED, Configuration
from wucht.analysis.configurations.state_names import NAMES
from wucht.analysis.vibration import unbalances
from wucht.machines.machine import Machine
from wucht.machines.operation import natural_frequencies
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.synchronous_states.prepare import Plan
from wucht.studies.synchronous_states.run import Findings

if TYPE_CHECKING:
    import xarray as xr

_NOTHING = {float: math.nan, int: -1}  # where the summary has None


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Put steady phase configurations into a Dataset.

    Coordinates: state, body (the main rotor first), body_name; with a map: map_speed, map_ratio, region. Variables of a state:
    name, speed, family_dimension, multiplicity, residual_unbalance (not a number where there is none), amplitude, stable_slow
    and stable_full (1, 0, or -1: not decided), verdict (both in words), overlapping, growth_slow and growth_full (largest real
    part of an exponent); (state, body): phase, as in the summary, and force_angle, the direction of its centrifugal force to
    the main rotor's, in its own sense; (body): unbalance. natural_frequency (mode). map_stable, map_exists (region, map_ratio,
    map_speed). comparable, an attribute: all turn about one axis. Of a family one member stands here, but stable_slow and
    stable_full hold for all that were looked at (-1 where they differ).
    """
    import xarray as xr_

    t, units = plan.torques, plan.machine.units
    states = sorted(findings.configurations, key=lambda c: c.rank)
    entries = [_entry(c) for c in states]
    natural = natural_frequencies(t.machine)
    data = _of_states(plan.machine, entries) | _of_bodies(plan, states)
    data["natural_frequency"] = variable("mode", list(natural.values()), "natural frequency", units.speed)
    coordinates = {
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
        "state": variable("state", np.arange(len(states)), "state"),
        "body_name": variable("body", list(t.names), "body"),
    }
    if findings.map is not None:
        cells, stable, exists = "region map_ratio map_speed", findings.map.stable, findings.map.exists
        data |= {
            "map_stable": variable(cells, stable.astype(np.int8), "a state of this kind is stable (averaged equations)"),
            "map_exists": variable(cells, exists.astype(np.int8), "a state of this kind exists"),
        }
        coordinates |= {
            "map_speed": variable("map_speed", findings.map.speed, "speed", units.speed),
            "map_ratio": variable("map_ratio", findings.map.ratio, "unbalance of the balancing bodies over that of the rotor"),
            "region": variable("region", list(REGIONS), "state"),
        }
    sense, sentence = float(t.senses[0]), _sentence(plan, states)
    summary = {
        "sentence": sentence,
        "speed": None if t.given is None else sense * t.given,
        "range": None if plan.speeds is None else [sense * w for w in plan.speeds],
        "full": plan.spec.full,
        "states": entries,
        "complete": findings.search.complete,
        "shown": findings.search.shown,
        "natural_frequencies": natural,
        "map": None if findings.map is None else _shares(findings.map),
    }
    warnings = _warnings(plan, findings, states)
    return answered(xr_.Dataset(data, coords=coordinates), summary, sentence, warnings, comparable=int(t.in_line))


def _of_states(machine: Machine, entries: Sequence[Mapping[str, Any]]) -> dict[str, Variable]:
    units = machine.units
    rate = f"1/{units.time}" if units.time else ""
    columns: dict[str, tuple[Any, str, str]] = {
        "name": ("U16", "name", ""),
        "speed": (float, "speed of the main rotor", units.speed),
        "residual_unbalance": (float, "unbalance that is left", _moment(machine)),
        "amplitude": (float, "amplitude of the axis", machine.orbit_unit if units.length else ""),
        "growth_slow": (float, "fastest growth in the averaged equations", rate),
        "growth_full": (float, "fastest growth in the full equations", rate),
        "stable_slow": (int, "stable in the averaged equations", ""),
        "stable_full": (int, "stable in the full equations", ""),
        "verdict": ("U40", "stability", ""),
        "overlapping": (int, "bodies of a track are in each other's place", ""),
        "family_dimension": (int, "dimension of the family of states", ""),
        "multiplicity": (int, "states that differ in equal bodies only", ""),
    }
    return {
        key: variable("state", np.array([_NOTHING.get(kind, "") if e[key] is None else e[key] for e in entries], kind), *words)
        for key, (kind, *words) in columns.items()
    }


def _of_bodies(plan: Plan, states: Sequence[Configuration]) -> dict[str, Variable]:
    t, angle = plan.torques, "rad" if plan.machine.units.time else ""
    own = dict(zip((b.name for b in t.machine.bodies), np.abs(unbalances(t.machine)), strict=True))
    turned = np.array([c.state.phases for c in states]).reshape(len(states), t.size)
    phases = np.array([[c.phases.get(n, 0.0) for n in t.names] for c in states]).reshape(len(states), t.size)
    return {
        "phase": variable("state body", phases, "phase", angle),
        "force_angle": variable("state body", turned, "direction of the centrifugal force to the rotor's", angle),
        "unbalance": variable("body", [own[n] for n in t.names], "unbalance", _moment(plan.machine)),
    }


def _moment(machine: Machine) -> str:
    if not machine.units.length:
        return ""
    return "kg m^2" if machine.labels == ("r",) else "kg m"


def _entry(c: Configuration) -> dict[str, Any]:
    return {
        "name": c.name, "type": c.type, "speed": c.speed, "phases": c.phases,
        "stable_slow": c.slow.stable, "stable_full": c.full.stable,
        "residual_unbalance": c.residual, "residual_share": c.share, "amplitude": c.amplitude,
        "family_dimension": c.state.dimension, "family_stable_share": c.stable_share, "multiplicity": c.state.multiplicity,
        "verdict": c.verdict, "overlapping": c.overlapping, "indifferent": c.state.indifferent,
        "growth_slow": None if c.slow.leading is None else c.slow.leading.real,
        "growth_full": None if c.full.leading is None else c.full.leading.real,
        "why": c.why, **({} if c.throw is None else c.throw.numbers),
    }  # fmt: skip


def _shares(regions: Regions) -> dict[str, Any]:
    """Which share of the map has a stable state of each kind, and none at all."""
    shares = {name: float(regions.stable[k].mean()) for k, name in enumerate(REGIONS)}
    return {"stable_share": shares | {"none": float((~regions.stable.any(axis=0)).mean())}}


def _sentence(plan: Plan, states: Sequence[Configuration]) -> str:
    if not states:
        return "no steady phase configurations: the bodies do not turn in step here"
    full, apart = plan.spec.full, [c for c in states if not c.overlapping]
    of_full = " only, undecided in the full ones" if full else " (the full ones were not asked)"
    words = {STABLE: STABLE, STABLE_SLOW: f"stable in the averaged equations{of_full}", UNDECIDED: UNDECIDED}
    present = {verdict: [c for c in apart if c.verdict == verdict] for verdict in words}
    clauses = [f"{words[verdict]}: {_counted(some)}" for verdict, some in present.items() if some]
    if not present[STABLE] and not present[STABLE_SLOW]:
        none = "none of them shown to be stable" if clauses else "none of them stable"
        clauses = [f"{none}{'' if full else ' in the averaged equations'}", *clauses]
    impossible = [c for c in states if c.overlapping and c.verdict in (STABLE, STABLE_SLOW)]
    if impossible:
        place = "could bodies lie in each other's place: where contacts bring them is seen in a run-up"
        clauses.append(f"{_counted(impossible)} would be, {place}")
    return f"{len(states)} steady phase configuration{'s' if len(states) > 1 else ''}, {'; '.join(clauses)}"


def _counted(states: Sequence[Configuration]) -> str:
    """The names of states, each with its number."""
    named = Counter(c.name or "without a name" for c in states)
    order = [n for n in (*NAMES, "without a name") if n in named]
    return ", ".join(f"{n} ({named[n]})" if named[n] > 1 else n for n in order)


def _warnings(plan: Plan, findings: Findings, states: Sequence[Configuration]) -> list[str]:
    machine, search, regions = plan.machine, findings.search, findings.map
    warnings = [f"{b.name} is taken as released" for b in machine.bodies if b.release is not None]
    overlap = "are left out: states in which its bodies overlap are marked"
    warnings += [f"contacts on the track {track.name} {overlap}" for track in machine.tracks]
    if not search.complete:
        warnings.append(f"not shown to be all states: {search.shown}")
    for c in states:
        if c.full.stable is not None and c.slow.stable not in (None, c.full.stable):
            phases = ", ".join(f"{math.degrees(p):.0f}" for p in c.phases.values())
            warnings.append(f"{c.name or 'a state'} at phases {phases} degrees: slow and full equations disagree; {c.why}")
    if plan.map is not None and (rows := 0 if regions is None else len(regions.ratio)) < len(plan.map[1]):
        warnings.append(f"{rows} of {len(plan.map[1])} rows of the map are computed")
    return warnings
