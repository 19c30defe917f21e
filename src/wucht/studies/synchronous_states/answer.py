"""The answer to the question of the steady phase configurations: states with their stability, and the map."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from wucht.analysis.configurations.averaged_stability import REGIONS, Regions
from wucht.analysis.configurations.configuration import NAMES, STABLE, STABLE_SLOW, UNDECIDED, UNSTABLE, Configuration
from wucht.analysis.configurations.search import StateSearch
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.synchronising_torque import SynchronisationMargin, has_exciters
from wucht.analysis.throw import NUMBERS, Throw
from wucht.analysis.vibration import unbalances
from wucht.machines.machine import Machine
from wucht.studies.answer import Answer
from wucht.studies.motion_variables import state_natural_vibrations
from wucht.studies.synchronisation_variables import margin_in_words, synchronisation_columns
from wucht.studies.synchronous_states.figure import select_states

_NOTHING = {float: math.nan, int: -1}  # where the summary has None
_VARIABLES: dict[str, Any] = {
    "name": "U16", "speed": float, "residual_unbalance": float, "amplitude": float, "growth_slow": float, "growth_full": float,
    "stable_slow": int, "stable_full": int, "verdict": "U40", "overlapping": int, "family_dimension": int, "multiplicity": int,
}  # fmt: skip
_MOST = 24  # states named one by one
_LINE = 0.5  # ratio of the stroke across to that along, below which it throws in a direction
_GENTLE = 0.05  # machine number below which the vibration is negligible
_DECISIONS = {True: "stable", False: "unstable", None: "undecided"}


def state_synchronous(
    a: Answer,
    machine: Machine,
    torques: SteadyTorques,
    speeds: tuple[float, float] | None,
    search: StateSearch,
    cells: tuple[np.ndarray, np.ndarray] | None,
    configurations: Sequence[Configuration],
    regions: Regions | None = None,
    *,
    is_full: bool,
) -> None:
    """State the answer. comparable, an attribute: all bodies turn about one axis.

    Of a family it has one member, but stable_slow and stable_full hold for all examined ones (-1 where they differ).
    speeds, cells: as prepared. regions: the part of the map that is computed. is_full: whether multipliers are.
    """
    states, sense = sorted(configurations, key=lambda c: c.rank), float(torques.senses[0])
    a.attribute(comparable=int(torques.is_coaxial))
    a.warn(*(f"{b.name} is assumed to be released" for b in machine.bodies if b.release is not None))
    for track in machine.tracks:
        a.warn(f"contacts on the track {track.name} are left out: states in which its bodies overlap are marked")
    fixed_speed = torques.fixed_speed
    a.number("speed", None if fixed_speed is None else sense * fixed_speed, "given speed of the main rotor", "speed")
    a.line("speed", "{speed}, given")
    a.number("range", speeds and [sense * w for w in speeds], "lowest and highest speed of the search", "speed")
    a.number("full", is_full, "whether the multipliers of the full equations are computed")
    _state_configurations(a, torques.machine, states, is_full=is_full, is_speed_given=fixed_speed is not None)
    _state_bodies(a, machine, torques, states)
    a.number("complete", search.complete, "whether these are proved to be all states")
    a.number("shown", search.evidence, "evidence for that")
    a.line("complete", f"{'yes' if search.complete else 'not proved'}: {{shown}}")
    if not search.complete:
        a.warn(f"not proved to be all states: {search.evidence}")
    for c in states:
        if c.full.stable is not None and c.slow.stable not in (None, c.full.stable):
            phases = ", ".join(f"{math.degrees(p):.0f}" for p in c.phases.values())
            place = f"{c.name or 'a state'} at phases {phases} degrees"
            a.warn(f"{place}: averaged and full equations disagree; {c.reason}")
    state_natural_vibrations(a, torques.machine)
    _state_map(a, regions)
    if cells is not None and (rows := 0 if regions is None else len(regions.ratio)) < len(cells[1]):
        a.warn(f"{rows} of {len(cells[1])} rows of the map are computed")
    a.sentence = _sentence(states, is_full=is_full)


def _state_configurations(
    a: Answer, machine: Machine, states: Sequence[Configuration], *, is_full: bool, is_speed_given: bool
) -> None:
    units = machine.units
    rate, angle = (f"1/{units.time}", "rad") if units.time else ("", "")
    growths = [[None if s.leading is None else s.leading.real for s in (c.slow, c.full)] for c in states]
    columns: dict[str, tuple[list[Any], str, str]] = {
        "name": ([c.name for c in states], "name", ""),
        "type": ([c.type for c in states], "kind of force balance", ""),
        "speed": ([c.speed for c in states], "speed of the main rotor", units.speed),
        "phases": ([c.phases for c in states], "phases of the bodies to the rotor", angle),
        "stable_slow": ([c.slow.stable for c in states], "stable in the averaged equations", ""),
        "stable_full": ([c.full.stable for c in states], "stable in the full equations", ""),
        "residual_unbalance": ([c.residual for c in states], "residual unbalance", _moment(machine)),
        "residual_share": ([c.share for c in states], "residual unbalance, as a share of the rotor's", ""),
        "amplitude": ([c.amplitude for c in states], "amplitude of the axis", machine.orbit_unit if units.length else ""),
        "family_dimension": ([c.state.dimension for c in states], "dimension of the family of states", ""),
        "family_stable_share": ([c.stable_share for c in states], "share of the family that is stable", ""),
        "multiplicity": ([c.state.multiplicity for c in states], "states that differ in equal bodies only", ""),
        "verdict": ([c.verdict for c in states], "stability", ""),
        "overlapping": ([c.overlapping for c in states], "bodies of a track overlap", ""),
        "indifferent": ([c.state.is_indifferent for c in states], "whether it exists at all greater speeds too", ""),
        "growth_slow": ([slow for slow, _ in growths], "fastest growth in the averaged equations", rate),
        "growth_full": ([full for _, full in growths], "fastest growth in the full equations", rate),
        "why": ([c.reason for c in states], "reason why the equations disagree or do not decide", ""),
    }  # fmt: skip
    margins = [None if c.verdict.startswith(UNSTABLE) else SynchronisationMargin.of(machine, c.speed, c.phases) for c in states]
    a.curve("state", np.arange(len(states)), "state")
    for name, kind in _VARIABLES.items():
        values, what, unit = columns[name]
        present_values = [_NOTHING.get(kind, "") if value is None else value for value in values]
        a.curve(name, np.array(present_values, kind), what, unit, "state")
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*(values for values, *_ in columns.values()), strict=True)]
    rows = [row | ({} if c.throw is None else c.throw.numbers) for row, c in zip(rows, states, strict=True)]
    parts = {name: (what, unit) for name, (_, what, unit) in columns.items()} | NUMBERS
    if has_exciters(machine):
        of_margins = synchronisation_columns(margins)
        rows = [row | {name: of[k] for name, (of, *_) in of_margins.items()} for k, row in enumerate(rows)]
        parts |= {name: (what, a.unit(*unit)) for name, (_, what, *unit) in of_margins.items()}
    a.number("states", rows, "steady phase configurations", parts=parts)
    for k in select_states([c.verdict for c in states], _MOST):
        c, at = states[k], f"states[{k}]"
        name = (c.name or f"state {k + 1}") + (f" ({c.type})" if c.type else "")
        place = "" if is_speed_given else " at {speed}"
        a.line(f"{name:18} ", f"{_stability(c, is_full)}{place}: {_description(c)}", at=at)
        if is_full:
            a.line("", "{why}", at=at)
        if c.throw is not None and c.throw.machine_number >= _GENTLE and not c.verdict.startswith("unstable"):
            a.line("", _throw_in_words(c.throw))
        if (margin := margins[k]) is not None:
            a.line("", margin_in_words(margin), at=at)
    if len(states) > _MOST:
        a.line(f"and {len(states) - _MOST} more: see the Dataset", "")


def _stability(c: Configuration, is_full: bool) -> str:
    slow, full = _DECISIONS[c.slow.stable], _DECISIONS[c.full.stable]
    if not is_full:
        return f"{slow} in the averaged equations"
    return slow if slow == full else f"{slow} in the averaged, {full} in the full equations"


def _description(c: Configuration) -> str:
    """Return the text on a state, with a field for its residual unbalance."""
    residual = "" if c.share is None else ", {residual_share:%} of the unbalance remains"
    family = f", one of a family of dimension {c.state.dimension}" if c.state.dimension else ""
    several = f", {c.state.multiplicity} ways" if c.state.multiplicity > 1 and not family else ""
    overlap = ", but bodies of a track would overlap" if c.overlapping else ""
    return f"{_angles(c, 2)}{residual}{family}{several}{overlap}"


def _angles(c: Configuration, decimals: int) -> str:
    """Return the phases of a state as text. One that is rounded to a whole turn is 0."""
    degrees = {body: round(math.degrees(phase), decimals) % 360 for body, phase in c.phases.items()}
    return ", ".join(f"{body} {phase:.{decimals}f}\u00b0" for body, phase in degrees.items())


def _throw_in_words(throw: Throw) -> str:
    """Return the stroke of the carrier and its machine number."""
    way = ""
    if throw.direction is not None and throw.ratio is not None and throw.ratio < _LINE:
        way = f" at {math.degrees(throw.direction):.1f}\u00b0"
    return f"stroke {1e3 * throw.stroke:.4g} mm peak to peak{way}, machine number {throw.machine_number:.3g}"


def _state_bodies(a: Answer, machine: Machine, torques: SteadyTorques, states: Sequence[Configuration]) -> None:
    """State the phases as in the summary, and directions of centrifugal forces to the main rotor's, in its sense."""
    t, angle = torques, "rad" if machine.units.time else ""
    size = dict(zip((b.name for b in t.machine.bodies), np.abs(unbalances(t.machine)), strict=True))
    force_angles = np.array([c.state.phases for c in states]).reshape(len(states), t.size)
    phases = np.array([[c.phases.get(n, 0.0) for n in t.names] for c in states]).reshape(len(states), t.size)
    a.curve("body_name", list(t.names), "body", "", "body", coordinate=True)
    a.curve("phase", phases, "phase", angle, "state body")
    a.curve("force_angle", force_angles, "direction of the centrifugal force to the rotor's", angle, "state body")
    a.curve("unbalance", [size[n] for n in t.names], "unbalance", _moment(machine), "body")
    a.curve("sense", np.asarray(t.senses, int), "sense of rotation, 1 counter-clockwise", "", "body")


def _moment(machine: Machine) -> str:
    """Return the unit of an unbalance."""
    if not machine.units.length:
        return ""
    return "kg m^2" if machine.labels == ("r",) else "kg m"


def _state_map(a: Answer, regions: Regions | None) -> None:
    """State the regions of the map in which each kind of state is stable, and their shares; that of none too."""
    shares = None
    if regions is not None:
        cells, stable = "region map_ratio map_speed", regions.stable.astype(np.int8)
        a.curve("map_speed", regions.speed, "speed", "speed")
        a.curve("map_ratio", regions.ratio, "unbalance of the balancing bodies over that of the rotor")
        a.curve("region", list(REGIONS), "state")
        a.curve("map_stable", stable, "a state of this kind is stable (averaged equations)", "", cells)
        a.curve("map_exists", regions.exists.astype(np.int8), "a state of this kind exists", "", cells)
        shares = {name: float(regions.stable[k].mean()) for k, name in enumerate(REGIONS)}
        shares["none"] = float((~regions.stable.any(axis=0)).mean())
        a.line("map", f"stable: {'; '.join(f'{name} {100 * share:.0f} %' for name, share in shares.items() if share)}")
    part = {"stable_share": ("share with a stable state of a kind", "")}
    a.number("map", None if shares is None else {"stable_share": shares}, "shares of the map", parts=part)


def _sentence(states: Sequence[Configuration], *, is_full: bool) -> str:
    if not states:
        return "no steady phase configurations: the bodies do not synchronise here"
    separate_states = [c for c in states if not c.overlapping]
    full_remark = " only, undecided in the full ones" if is_full else " (the full ones were not evaluated)"
    words = {STABLE: STABLE, STABLE_SLOW: f"stable in the averaged equations{full_remark}", UNDECIDED: UNDECIDED}
    present = {verdict: [c for c in separate_states if c.verdict == verdict] for verdict in words}
    clauses = [f"{words[verdict]}: {_name_counts(group)}" for verdict, group in present.items() if group]
    if not present[STABLE] and not present[STABLE_SLOW]:
        headline = "none of them proved stable" if clauses else "none of them stable"
        clauses = [f"{headline}{'' if is_full else ' in the averaged equations'}", *clauses]
    impossible = [c for c in states if c.overlapping and c.verdict in (STABLE, STABLE_SLOW)]
    if impossible:
        place = "could bodies overlap: a run-up shows where contacts move them"
        clauses.append(f"{_name_counts(impossible)} would be, {place}")
    return f"{len(states)} steady phase configuration{'s' if len(states) > 1 else ''}, {'; '.join(clauses)}"


def _name_counts(states: Sequence[Configuration]) -> str:
    """Return the names of states, each with its count; of one that has none its phases, of several how many they are."""
    counts = Counter(c.name for c in states if c.name)
    names = [f"{n} ({counts[n]})" if counts[n] > 1 else n for n in NAMES if n in counts]
    without_name = [c for c in states if not c.name]
    if len(without_name) == 1:
        return ", ".join([*names, _angles(without_name[0], 1)])
    return ", ".join([*names, *([f"{len(without_name)} {'others' if names else 'of them'}"] if without_name else [])])
