"""The Dataset of constant phases: the states with their stability, the stability map, and the summary."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import Machine
from wucht.machines.vibration import unbalances
from wucht.results.conventions import Variable, variable
from wucht.studies.attributes import attributes
from wucht.studies.synchronous_states.found import NAMES, STABLE, STABLE_SLOW, UNDECIDED, Configurations, Judged
from wucht.studies.synchronous_states.map import REGIONS, StabilityMap, stability_map

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.synchronous_states.study import SynchronousStates


_TEXT = {"name": "U16", "verdict": "U40"}


def result(machine: Machine, question: SynchronousStates, found: Configurations, begun: float) -> xr.Dataset:
    """Put constant phases into a Dataset.

    Coordinates: state, body (the main rotor first), body_name; with a map: map_speed, map_ratio, region. Variables of a state:
    name, speed, family_dimension, multiplicity, residual_unbalance (not a number where there is none), amplitude, stable_slow
    and stable_full (1, 0, or -1: not decided), verdict (both in words), overlapping, growth_slow and growth_full (largest real
    part of an exponent); (state, body): phase, as in the summary, and force_angle, the direction of its centrifugal force to
    the main rotor's, in its own sense; (body): unbalance. natural_frequency (mode). map_stable, map_exists (region, map_ratio,
    map_speed). comparable, an attribute: all turn about one axis. Of a family one member stands here, but stable_slow and
    stable_full hold for all that were looked at (-1 where they differ). begun: ``perf_counter()`` at the beginning.
    """
    import xarray as xr_

    t, units = found.torques, machine.units
    natural = natural_frequencies(found.machine)
    data = _of_states(machine, found) | _of_bodies(machine, found)
    data["natural_frequency"] = variable("mode", list(natural.values()), "natural frequency", units.speed)
    coordinates = {
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
        "state": variable("state", np.arange(len(found.judged)), "state"),
        "body_name": variable("body", list(t.names), "body"),
    }
    drawn = None
    if question.axes is not None:
        drawn = stability_map(t, question.axes["speed"], question.axes["ratio"])
        data |= _mapped(drawn)
        coordinates |= {
            "map_speed": variable("map_speed", drawn.speed, "speed", units.speed),
            "map_ratio": variable("map_ratio", drawn.ratio, "unbalance of the balancing bodies over that of the rotor"),
            "region": variable("region", list(REGIONS), "state"),
        }
    dataset = xr_.Dataset(data, coords=coordinates)
    dataset.attrs["comparable"] = int(found.in_line)
    sentence = _sentence(found)
    _, complete, shown = found.found
    summary = {
        "sentence": sentence,
        "speed": None if t.given is None else float(t.senses[0]) * t.given,
        "range": None if t.given is not None else [float(t.senses[0]) * w for w in (found.speeds.low, found.speeds.high)],
        "full": question.full,
        "states": [_entry(j) for j in found.judged],
        "complete": complete,
        "shown": shown,
        "natural_frequencies": natural,
        "map": None if drawn is None else _shares(drawn),
    }
    dataset.attrs |= attributes(machine, question, summary, sentence, _warnings(machine, found), begun)
    return dataset


def _of_states(machine: Machine, found: Configurations) -> dict[str, Variable]:
    states, units = found.judged, machine.units
    rate = f"1/{units.time}" if units.time else ""
    columns: dict[str, tuple[list[Any], str, str]] = {
        "name": ([j.name or "" for j in states], "name", ""),
        "speed": ([j.speed for j in states], "speed of the main rotor", units.speed),
        "residual_unbalance": ([_number(j.residual) for j in states], "unbalance that is left", _moment(machine)),
        "amplitude": ([j.amplitude for j in states], "amplitude of the axis", machine.orbit_unit if units.length else ""),
        "growth_slow": ([_growth(j.slow.leading) for j in states], "fastest growth in the slow equations", rate),
        "growth_full": ([_growth(j.full.leading) for j in states], "fastest growth in the full equations", rate),
        "stable_slow": ([_flag(j.slow.stable) for j in states], "stable in the slow equations", ""),
        "stable_full": ([_flag(j.full.stable) for j in states], "stable in the full equations", ""),
        "verdict": ([j.verdict for j in states], "stability", ""),
        "overlapping": ([int(j.overlapping) for j in states], "bodies of a track are in each other's place", ""),
        "family_dimension": ([j.state.dimension for j in states], "dimension of the family of states", ""),
        "multiplicity": ([j.state.multiplicity for j in states], "states that differ in equal bodies only", ""),
    }
    return {name: variable("state", np.array(v, dtype=_TEXT.get(name)), *rest) for name, (v, *rest) in columns.items()}


def _of_bodies(machine: Machine, found: Configurations) -> dict[str, Variable]:
    states, t, angle = found.judged, found.torques, "rad" if machine.units.time else ""
    own = dict(zip((b.name for b in machine.bodies), np.abs(unbalances(found.machine)), strict=True))
    turned = np.array([j.state.phases for j in states]).reshape(len(states), t.size)
    phases = np.array([[j.phases.get(n, 0.0) for n in t.names] for j in states]).reshape(len(states), t.size)
    return {
        "phase": variable("state body", phases, "phase", angle),
        "force_angle": variable("state body", turned, "direction of the centrifugal force to the rotor's", angle),
        "unbalance": variable("body", [own[n] for n in t.names], "unbalance", _moment(machine)),
    }


def _moment(machine: Machine) -> str:
    if not machine.units.length:
        return ""
    return "kg m^2" if machine.labels == ("r",) else "kg m"


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _growth(value: complex | None) -> float:
    return math.nan if value is None else value.real


def _flag(stable: bool | None) -> int:
    return -1 if stable is None else int(stable)


def _entry(j: Judged) -> dict[str, Any]:
    return {
        "name": j.name,
        "type": j.type,
        "speed": j.speed,
        "phases": j.phases,
        "stable_slow": j.slow.stable,
        "stable_full": j.full.stable,
        "residual_unbalance": j.residual,
        "residual_share": j.share,
        "amplitude": j.amplitude,
        "family_dimension": j.state.dimension,
        "family_stable_share": j.stable_share,
        "multiplicity": j.state.multiplicity,
        "verdict": j.verdict,
        "overlapping": j.overlapping,
        "indifferent": j.state.indifferent,
        "growth_slow": None if j.slow.leading is None else j.slow.leading.real,
        "growth_full": None if j.full.leading is None else j.full.leading.real,
        "why": j.why,
    }


def _mapped(drawn: StabilityMap) -> dict[str, Any]:
    dimensions = "region map_ratio map_speed"
    return {
        "map_stable": variable(dimensions, drawn.stable.astype(np.int8), "a state of this kind is stable (slow equations)"),
        "map_exists": variable(dimensions, drawn.exists.astype(np.int8), "a state of this kind exists"),
    }


def _shares(drawn: StabilityMap) -> dict[str, Any]:
    """Which share of the map has a stable state of each kind, and none at all."""
    found = {name: float(drawn.stable[k].mean()) for k, name in enumerate(REGIONS)}
    return {"stable_share": found | {"none": float((~drawn.stable.any(axis=0)).mean())}}


def _sentence(found: Configurations) -> str:
    states = found.judged
    if not states:
        return "no constant phases: the bodies do not turn in step here"
    count = f"{len(states)} constant phase configuration{'s' if len(states) > 1 else ''}"
    apart = [j for j in states if not j.overlapping]
    alone = (
        "stable in the slow equations only, undecided in the full ones" if found.full
        else "stable in the slow equations (the full ones were not asked)"
    )  # fmt: skip
    said = [
        f"{words}: {_counted([j for j in apart if j.verdict == verdict])}"
        for verdict, words in ((STABLE, STABLE), (STABLE_SLOW, alone), (UNDECIDED, UNDECIDED))
        if any(j.verdict == verdict for j in apart)
    ]
    if not any(j.verdict in (STABLE, STABLE_SLOW) for j in apart):
        none = "none of them shown to be stable" if said else "none of them stable"
        said = [f"{none}{'' if found.full else ' in the slow equations'}", *said]
    impossible = [j for j in states if j.overlapping and j.verdict in (STABLE, STABLE_SLOW)]
    if impossible:
        place = "could bodies lie in each other's place: where contacts bring them a run-up tells"
        said.append(f"{_counted(impossible)} would be, {place}")
    return f"{count}, {'; '.join(said)}"


def _counted(states: Sequence[Judged]) -> str:
    """The names of states, each with its number."""
    named = Counter(j.name or "without a name" for j in states)
    order = [n for n in (*NAMES, "without a name") if n in named]
    return ", ".join(f"{n} ({named[n]})" if named[n] > 1 else n for n in order)


def _warnings(machine: Machine, found: Configurations) -> list[str]:
    said = [f"{b.name} is taken as released" for b in machine.bodies if b.release is not None]
    for track in machine.tracks:
        said.append(f"contacts on the track {track.name} are left out: states in which its bodies overlap are marked")
    if not found.found[1]:
        said.append(f"not shown to be all states: {found.found[2]}")
    differing = [j for j in found.judged if j.full.stable is not None and j.slow.stable not in (None, j.full.stable)]
    for j in differing:
        kind = f"{j.name or 'a state'} at phases {', '.join(f'{math.degrees(p):.0f}' for p in j.phases.values())} degrees"
        said.append(f"{kind}: slow and full equations disagree; {j.why}")
    return said
