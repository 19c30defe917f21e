"""Members of an ensemble whose bodies share tracks: in each order of the bodies other ones touch, by other equations.

Bodies that are alike exchange their places: which of them is where does not matter to the machine, and few orders remain.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from wucht.dynamics.run_ups.initial_state import angles_in, machine_in_state
from wucht.dynamics.sampling.ensemble_equations import Variants
from wucht.machines.machine import Machine
from wucht.machines.parts.base import ShaftPart
from wucht.machines.parts.track import Track


def members_by_order(
    machine: Machine, variants: Variants, starts: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, Variants]]:
    """Yield the members that start in states (n, M), by the order of the bodies on the tracks: the numbers (k,) of those in one
    order, their starts (n, k) and machines.

    Raises ``InputError`` where bodies of a track overlap.
    """
    if not machine.tracks:
        yield np.arange(starts.shape[1]), starts, variants
        return
    new_starts = np.array(starts, float)
    groups = dict[tuple[tuple[str, ...], ...], dict[tuple[float, ...], tuple[Machine, list[int]]]]()
    for i, start in enumerate(new_starts.T):
        member_machine = variants.machines[variants.machine_index[i]]
        _exchange_like_bodies(member_machine, start)
        member_machine = machine_in_state(member_machine, start)
        group = groups.setdefault(tuple(track.order for track in member_machine.tracks), {})
        group.setdefault(tuple(member_machine.values.values()), (member_machine, []))[1].append(i)
    for group in groups.values():
        members = np.array([i for _, same in group.values() for i in same])
        machine_index = np.repeat(np.arange(len(group)), [len(same) for _, same in group.values()])
        yield members, new_starts[:, members], Variants(tuple(m for m, _ in group.values()), machine_index)


def _exchange_like_bodies(machine: Machine, state: np.ndarray) -> None:
    """Exchange the angles and speeds of like bodies of each track in a state (n,): they are then in the order of the file."""
    angles, rows = angles_in(machine, state), _body_rows(machine)
    for track in machine.tracks:
        first = angles[track.bodies[0].name]
        places = sorted((b.name for b in track.bodies), key=lambda name: (angles[name] - first) % (2 * math.pi))
        for names in _like_bodies(machine, track):
            sources = [name for name in places if name in names]
            state[[row for name in names for row in rows[name]]] = state[[row for name in sources for row in rows[name]]]


def _body_rows(machine: Machine) -> Mapping[str, list[int]]:
    """Return the rows of a state that belong to each body."""
    return {b.name: [i for i, s in enumerate(machine.state_names) if s.startswith(f"{b.name}.")] for b in machine.bodies}


def _like_bodies(machine: Machine, track: Track) -> list[list[str]]:
    """Return the names of a track's bodies, those that are alike together: of one kind, with the same values.

    One that is scheduled, released, or has a drive, a load or a further body, is like no other one.
    """
    groups = dict[tuple[object, ...], list[str]]()
    unique_names = {b.about for b in machine.bodies} | {x.about for x in machine.sliders}
    unique_names |= {part.on for part in machine.parts if isinstance(part, ShaftPart)}
    unique_names |= {s.parameter.partition(".")[0] for s in machine.schedules}
    unique_names |= {b.name for b in machine.bodies if b.release is not None}
    for body in track.bodies:
        prefix = f"{body.name}."
        values = {p.removeprefix(prefix): v for p, v in machine.values.items() if p.startswith(prefix)}
        unique_name = body.name if body.name in unique_names else None
        groups.setdefault((unique_name, body.kind, body.about, *sorted(values.items())), []).append(body.name)
    return list(groups.values())
