"""Findings -> the quantities of synchronous states with their stability, and their lines in a report."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.configurations.averaged_stability import REGIONS, Regions
from wucht.analysis.configurations.configuration import NAMES, STABLE, STABLE_SLOW, UNDECIDED, Configuration
from wucht.analysis.throw import NUMBERS
from wucht.analysis.vibration import unbalances
from wucht.machines.machine import Machine
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.motion_variables import natural_vibrations
from wucht.studies.synchronous_states.computation import Findings, Plan

if TYPE_CHECKING:
    import xarray as xr


_NOTHING = {float: math.nan, int: -1}  # where the summary has None


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of steady phase configurations. comparable, an attribute: all bodies turn about one axis.

    Of a family it has one member, but stable_slow and stable_full hold for all examined ones (-1 where they differ).
    """
    t, search, unit = plan.torques, findings.search, plan.machine.units.speed
    states, sense = sorted(findings.configurations, key=lambda c: c.rank), float(t.senses[0])
    given_speed, limits = (
        None if t.fixed_speed is None else sense * t.fixed_speed,
        plan.speeds and [sense * w for w in plan.speeds],
    )
    quantities = [
        Quantity("speed", given_speed, "given speed of the main rotor", unit),
        Quantity("range", limits, "lowest and highest speed of the search", unit),
        Quantity("full", plan.spec.full, "whether the multipliers of the full equations are computed"),
        *_state_quantities(plan.machine, [_state_entry(c) for c in states]),
        *_body_quantities(plan, states),
        Quantity("complete", search.complete, "whether these are proved to be all states"),
        Quantity("shown", search.evidence, "evidence for that"),
        *natural_vibrations(t.machine),
        *_map_quantities(findings.map, unit),
    ]
    return result_dataset(quantities, _sentence(plan, states), _warnings(plan, findings, states), comparable=int(t.is_coaxial))


def _state_quantities(machine: Machine, entries: Sequence[Mapping[str, Any]]) -> list[Quantity]:
    units = machine.units
    rate, angle = (f"1/{units.time}", "rad") if units.time else ("", "")
    columns: dict[str, tuple[Any, str, str]] = {
        "name": ("U16", "name", ""),
        "speed": (float, "speed of the main rotor", units.speed),
        "residual_unbalance": (float, "residual unbalance", _moment(machine)),
        "amplitude": (float, "amplitude of the axis", machine.orbit_unit if units.length else ""),
        "growth_slow": (float, "fastest growth in the averaged equations", rate),
        "growth_full": (float, "fastest growth in the full equations", rate),
        "stable_slow": (int, "stable in the averaged equations", ""),
        "stable_full": (int, "stable in the full equations", ""),
        "verdict": ("U40", "stability", ""),
        "overlapping": (int, "bodies of a track overlap", ""),
        "family_dimension": (int, "dimension of the family of states", ""),
        "multiplicity": (int, "states that differ in equal bodies only", ""),
    }
    parts = {key: (description, unit) for key, (_, description, unit) in columns.items()} | NUMBERS | {
        "type": ("kind of force balance", ""),
        "phases": ("phases of the bodies to the rotor", angle),
        "residual_share": ("residual unbalance, as a share of the rotor's", ""),
        "family_stable_share": ("share of the family that is stable", ""),
        "indifferent": ("whether it exists at all greater speeds too", ""),
        "why": ("reason why the equations disagree or do not decide", ""),
    }  # fmt: skip
    variables = [
        Quantity(
            key,
            np.array([_NOTHING.get(kind, "") if e[key] is None else e[key] for e in entries], kind),
            description,
            unit,
            "state",
        )
        for key, (kind, description, unit) in columns.items()
    ]
    numbers = Quantity("state", np.arange(len(entries)), "state", "", "state")
    return [numbers, *variables, Quantity("states", entries, "steady phase configurations", parts=parts)]


def _body_quantities(plan: Plan, states: Sequence[Configuration]) -> list[Quantity]:
    """Return the phases as in the summary, and directions of centrifugal forces to the main rotor's, in its sense."""
    t, angle = plan.torques, "rad" if plan.machine.units.time else ""
    size = dict(zip((b.name for b in t.machine.bodies), np.abs(unbalances(t.machine)), strict=True))
    force_angles = np.array([c.state.phases for c in states]).reshape(len(states), t.size)
    phases = np.array([[c.phases.get(n, 0.0) for n in t.names] for c in states]).reshape(len(states), t.size)
    return [
        Quantity("body_name", list(t.names), "body", "", "body", coordinate=True),
        Quantity("phase", phases, "phase", angle, "state body"),
        Quantity("force_angle", force_angles, "direction of the centrifugal force to the rotor's", angle, "state body"),
        Quantity("unbalance", [size[n] for n in t.names], "unbalance", _moment(plan.machine), "body"),
        Quantity("sense", np.asarray(t.senses, int), "sense of rotation, 1 counter-clockwise", "", "body"),
    ]


def _map_quantities(regions: Regions | None, speed: str) -> list[Quantity]:
    """Return the regions of the map in which each kind of state is stable, and their shares; that of none too."""
    description, part = "shares of the map", {"stable_share": ("share with a stable state of a kind", "")}
    if regions is None:
        return [Quantity("map", None, description, parts=part)]
    cells, stable, exists = "region map_ratio map_speed", regions.stable.astype(np.int8), regions.exists.astype(np.int8)
    shares = {name: float(regions.stable[k].mean()) for k, name in enumerate(REGIONS)}
    shares["none"] = float((~regions.stable.any(axis=0)).mean())
    return [
        Quantity("map_speed", regions.speed, "speed", speed, "map_speed"),
        Quantity("map_ratio", regions.ratio, "unbalance of the balancing bodies over that of the rotor", "", "map_ratio"),
        Quantity("region", list(REGIONS), "state", "", "region"),
        Quantity("map_stable", stable, "a state of this kind is stable (averaged equations)", "", cells),
        Quantity("map_exists", exists, "a state of this kind exists", "", cells),
        Quantity("map", {"stable_share": shares}, description, parts=part),
    ]


def _moment(machine: Machine) -> str:
    if not machine.units.length:
        return ""
    return "kg m^2" if machine.labels == ("r",) else "kg m"


def _state_entry(c: Configuration) -> dict[str, Any]:
    return {
        "name": c.name, "type": c.type, "speed": c.speed, "phases": c.phases,
        "stable_slow": c.slow.stable, "stable_full": c.full.stable,
        "residual_unbalance": c.residual, "residual_share": c.share, "amplitude": c.amplitude,
        "family_dimension": c.state.dimension, "family_stable_share": c.stable_share, "multiplicity": c.state.multiplicity,
        "verdict": c.verdict, "overlapping": c.overlapping, "indifferent": c.state.is_indifferent,
        "growth_slow": None if c.slow.leading is None else c.slow.leading.real,
        "growth_full": None if c.full.leading is None else c.full.leading.real,
        "why": c.reason, **({} if c.throw is None else c.throw.numbers),
    }  # fmt: skip


def _sentence(plan: Plan, states: Sequence[Configuration]) -> str:
    if not states:
        return "no steady phase configurations: the bodies do not synchronise here"
    full, separate_states = plan.spec.full, [c for c in states if not c.overlapping]
    full_remark = " only, undecided in the full ones" if full else " (the full ones were not evaluated)"
    words = {STABLE: STABLE, STABLE_SLOW: f"stable in the averaged equations{full_remark}", UNDECIDED: UNDECIDED}
    present = {verdict: [c for c in separate_states if c.verdict == verdict] for verdict in words}
    clauses = [f"{words[verdict]}: {_name_counts(group)}" for verdict, group in present.items() if group]
    if not present[STABLE] and not present[STABLE_SLOW]:
        headline = "none of them proved stable" if clauses else "none of them stable"
        clauses = [f"{headline}{'' if full else ' in the averaged equations'}", *clauses]
    impossible = [c for c in states if c.overlapping and c.verdict in (STABLE, STABLE_SLOW)]
    if impossible:
        place = "could bodies overlap: a run-up shows where contacts move them"
        clauses.append(f"{_name_counts(impossible)} would be, {place}")
    return f"{len(states)} steady phase configuration{'s' if len(states) > 1 else ''}, {'; '.join(clauses)}"


def _name_counts(states: Sequence[Configuration]) -> str:
    """Return the names of states, each with its count."""
    counts = Counter(c.name or "without a name" for c in states)
    order = [n for n in (*NAMES, "without a name") if n in counts]
    return ", ".join(f"{n} ({counts[n]})" if counts[n] > 1 else n for n in order)


def _warnings(plan: Plan, findings: Findings, states: Sequence[Configuration]) -> list[str]:
    machine, search, regions = plan.machine, findings.search, findings.map
    warnings = [f"{b.name} is assumed to be released" for b in machine.bodies if b.release is not None]
    overlap = "are left out: states in which its bodies overlap are marked"
    warnings += [f"contacts on the track {track.name} {overlap}" for track in machine.tracks]
    if not search.complete:
        warnings.append(f"not proved to be all states: {search.evidence}")
    for c in states:
        if c.full.stable is not None and c.slow.stable not in (None, c.full.stable):
            phases = ", ".join(f"{math.degrees(p):.0f}" for p in c.phases.values())
            place = f"{c.name or 'a state'} at phases {phases} degrees"
            warnings.append(f"{place}: averaged and full equations disagree; {c.reason}")
    if plan.map is not None and (rows := 0 if regions is None else len(regions.ratio)) < len(plan.map[1]):
        warnings.append(f"{rows} of {len(plan.map[1])} rows of the map are computed")
    return warnings


_MOST = 24  # states named one by one
_LINE = 0.5  # ratio of the stroke across to that along, below which it throws in a direction
_GENTLE = 0.05  # machine number below which the vibration is negligible


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for synchronous states."""
    s, lines = result.wucht.summary, ReportLines(result)
    lines.add("speed", "{speed}, given")
    for state in (s["states"][k] for k in select_states([entry["verdict"] for entry in s["states"]], _MOST)):
        name = (state["name"] or "no name") + (f" ({state['type']})" if state["type"] else "")
        lines.add(f"{name:18} ", _line(state, "" if s["speed"] is not None else " at {speed}", s["full"]), state, "states")
        if s["full"]:
            lines.add("", "{why}", state)
        if state.get("machine_number", 0.0) >= _GENTLE and not state["verdict"].startswith("unstable"):
            lines.add("", _throw(state))
    if len(s["states"]) > _MOST:
        lines.add(f"and {len(s['states']) - _MOST} more: see the Dataset", "")
    lines.add("complete", f"{'yes' if s['complete'] else 'not proved'}: {s['shown']}")
    if s["map"] is not None:
        shares = "; ".join(f"{name} {100 * share:.0f} %" for name, share in s["map"]["stable_share"].items() if share)
        lines.add("map", f"stable: {shares}")
    return lines.report(s["sentence"])


def select_states(verdicts: Sequence[str], most: int) -> list[int]:
    """Select the states to be shown, in their order: of too many, unstable ones are left out first."""
    return sorted(sorted(range(len(verdicts)), key=lambda k: verdicts[k].startswith("unstable"))[:most])


def _line(state: dict[str, Any], at: str, full: bool) -> str:
    angles = ", ".join(f"{body} {_degrees(phase)}\u00b0" for body, phase in state["phases"].items())
    residual = "" if state["residual_share"] is None else ", {residual_share:%} of the unbalance remains"
    family = ", one of a family of dimension {family_dimension:d}" if state["family_dimension"] else ""
    several = ", {multiplicity:d} ways" if state["multiplicity"] > 1 and not family else ""
    overlap = ", but bodies of a track would overlap" if state["overlapping"] else ""
    return f"{_stability(state, full)}{at}: {angles}{residual}{family}{several}{overlap}"


def _throw(state: dict[str, Any]) -> str:
    """Return the stroke of the carrier and its machine number."""
    direction = state["throw_direction"]
    way = "" if direction is None or state["throw_ratio"] >= _LINE else f" at {math.degrees(direction):.1f}\u00b0"
    return f"stroke {1e3 * state['stroke']:.4g} mm peak to peak{way}, machine number {state['machine_number']:.3g}"


def _degrees(phase: float) -> str:
    """Return a phase in degrees; one that is rounded to a whole turn is 0."""
    return f"{round(math.degrees(phase), 2) % 360:.2f}"


def _stability(state: dict[str, Any], full: bool) -> str:
    slow, exact = state["stable_slow"], state["stable_full"]
    words = {True: "stable", False: "unstable", None: "undecided"}
    if not full:
        return f"{words[slow]} in the averaged equations"
    if slow == exact:
        return words[slow]
    return f"{words[slow]} in the averaged, {words[exact]} in the full equations"
