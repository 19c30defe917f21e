"""Compliant contacts between neighbours on one track, which cannot pass each other.

A contact is a ``stop`` between the angles of two neighbours. Its frequency omega_c is twenty times that of the fastest
operation which drives and schedules reach, so that it is short against a turn: two bodies that meet with a relative speed u
overlap by less than u/omega_c.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import TypeVar

import sympy as sp

from wucht.errors import InputError
from wucht.machines.mechanism import Mechanism
from wucht.machines.parts.stop import stop
from wucht.machines.parts.track import RESTITUTION, Track, TrackBody
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.schema import Parameter

FREQUENCY_RATIO = 20.0  # of the contact to the fastest operating speed


_PLAY = 1e-9  # rad: clearance of bodies that just touch at the start


def tracks_of(bodies: Sequence[TrackBody], frequency: Mapping[str, float], given_names: Collection[str]) -> tuple[Track, ...]:
    """Return the tracks of a machine. frequency: of the contacts by track; given_names: the tracks with a given frequency.

    Raises ``InputError``: bodies of one track on different circles or about different bodies, or too many for it.
    """
    by_track: dict[str, list[TrackBody]] = {}
    for b in bodies:
        if b.track is not None:
            by_track.setdefault(b.track, []).append(b)
    for together in by_track.values():
        first = together[0]
        for b in together[1:]:
            place = f"{b.path}.track"
            if b.reference != first.reference:
                raise InputError(
                    place, b.track, f"{first.name!r} of this track turns about {first.reference!r}", code="other-centre"
                )
            if abs(b.centre_radius() - first.centre_radius()) > 1e-9 * first.centre_radius():
                circle = f"the centre of {first.name!r} of this track runs on a circle of radius {first.centre_radius():g} m"
                raise InputError(
                    place, b.track, f"{circle}, that of this body on one of {b.centre_radius():g} m", code="other-circle"
                )
        if len(together) > 1 and sum(angular_width(a, b) for a, b in _neighbours(together)) > 2 * math.pi:
            raise InputError(f"{first.path}.track", first.track, f"{len(together)} bodies of this size do not fit on it")
    return tuple(Track(name, tuple(ts), frequency[name], name in given_names) for name, ts in by_track.items() if len(ts) > 1)


def _neighbours(bodies: Sequence[TrackBody]) -> list[tuple[TrackBody, TrackBody]]:
    return list(zip(bodies, [*bodies[1:], bodies[0]], strict=True))


def angular_width(a: TrackBody, b: TrackBody) -> float:
    """Return the angle between the centres of two bodies that touch, in rad."""
    half = ((a.width() or 0.0) + (b.width() or 0.0)) / (4 * a.centre_radius())
    return 2 * math.asin(min(half, 1.0))


def side_by_side_angles(bodies: Sequence[TrackBody]) -> dict[str, float]:
    """Return angles at which bodies of a track touch, in the given order, counter-clockwise from the first one at 0."""
    widths = [angular_width(a, b) for a, b in pairwise(bodies)]
    return {b.name: angle for b, angle in zip(bodies, accumulate(widths, initial=0.0), strict=True)}


def _gap(track: Track, k: int, a: Coordinate, b: Coordinate) -> sp.Expr:
    """Return the angle between two neighbours, negative while they touch. k: the number of the first, counter-clockwise."""
    return b.position - a.position + track.symbol(f"offset_{k + 1}")


def gaps(machine: Mechanism, track: Track) -> tuple[sp.Expr, ...]:
    """Return the angles between neighbours on a track of a machine, negative while they touch, in rad."""
    along = [machine.body(name).coordinate for name in track.order]
    return tuple(_gap(track, k, a, b) for k, (a, b) in enumerate(zip(along, [*along[1:], along[0]], strict=True)))


def balancing_capacity(moments: Mapping[str, float], bodies: Sequence[TrackBody]) -> float:
    """Return the largest unbalance that bodies about one rotor can compensate together.

    moments: the unbalance of each, by name; those that can pass each other add up. bodies: those of them that are on tracks,
    where they come no nearer than side by side: n equal ones, the angle a from one to the next, have U sin(n a/2)/sin(a/2).
    """
    tracks = dict[str, list[TrackBody]]()
    for b in bodies:
        if b.track is not None:
            tracks.setdefault(b.track, []).append(b)
    on_track = {b.name for track in tracks.values() for b in track}
    free = sum(abs(moment) for name, moment in moments.items() if name not in on_track)
    return free + sum(_largest_sum(track, moments) for track in tracks.values())


def _largest_sum(bodies: Sequence[TrackBody], moment: Mapping[str, float]) -> float:
    """Return the largest sum of the unbalances of a track's bodies, in their order: the row begins at any."""
    angles = starts(bodies)
    order = sorted(bodies, key=lambda b: angles[b.name] % (2 * math.pi))
    sums = []
    for k in range(len(order)):
        row = [*order[k:], *order[:k]]
        sums.append(abs(sum(abs(moment[n]) * cmath.exp(1j * angle) for n, angle in side_by_side_angles(row).items())))
    return float(max(sums))


def _contacts(
    track: Track, order: Sequence[TrackBody], offsets: Sequence[float], angles: Mapping[str, Coordinate]
) -> tuple[Energies, tuple[Parameter, ...]]:
    """Return energies and parameters of a track's contacts. order: the bodies counter-clockwise. offsets: of each gap."""
    frequency, contacts = track.symbol("contact_frequency"), list[Energies]()
    parameters = [Parameter(frequency.name, track.frequency, "rad/s", "omega_c", "frequency of the contacts")]
    for k, (a, b) in enumerate(_neighbours(order)):
        offset = track.symbol(f"offset_{k + 1}")
        gap = _gap(track, k, angles[a.name], angles[b.name])
        rate = angles[b.name].velocity - angles[a.name].velocity
        inertia = a.axis_inertia() * b.axis_inertia() / (a.axis_inertia() + b.axis_inertia())
        bounce = sum(sp.log(body.symbol("restitution")) for body in (a, b)) / 2
        contacts.append(stop(gap, rate, inertia, frequency, bounce))
        meaning = f"angle added to the gap {a.name} to {b.name}"
        parameters.append(Parameter(offset.name, offsets[k], "rad", f"delta_{k + 1}", meaning))
    for name in (b.name for b in track.bodies if b.restitution is None):
        parameters.append(Parameter(f"{name}.restitution", RESTITUTION, "", "e", "coefficient of restitution"))
    return sum(contacts, Energies()), tuple(parameters)


MechanismT = TypeVar("MechanismT", bound=Mechanism)


def arrange_contacts(
    machine: MechanismT, angles: Mapping[str, float], fastest: float = 0.0, location: str = "study.start"
) -> MechanismT:
    """Return the machine with contacts between those bodies that are neighbours at these angles (absolute, in rad).

    fastest: the largest speed at the start, in rad/s: contacts without a frequency in the file are fast compared with it too.
    Where the order is that of the machine, only the offsets change: its equations need not be derived again.
    Raises ``InputError`` where two bodies overlap.
    """
    if not machine.tracks:
        return machine
    coordinates = {b.name: b.coordinate for b in machine.bodies}
    energies, offsets, tracks = list[Energies](), dict[str, float](), list[Track]()
    parameters = dict(machine.parameters)
    for track in machine.tracks:
        order = _order(track, angles)
        contact, more = _contacts(track, order, _offsets(track, order, angles, location), coordinates)
        energies.append(contact)
        tracks.append(replace(track, order=tuple(b.name for b in order)))
        offsets |= {p.path: p.value for p in more if "offset" in p.path}
        if not track.is_frequency_given:
            offsets[track.symbol("contact_frequency").name] = max(track.frequency, FREQUENCY_RATIO * fastest)
        parameters |= {p.path: p for p in more if p.path not in machine.parameters}
    if [t.order for t in tracks] == [t.order for t in machine.tracks]:
        return machine.with_unchecked_values(offsets)
    new_machine = machine.with_fields(
        energies=(*machine.without_contacts, *energies), parameters=parameters, tracks=tuple(tracks)
    )
    return new_machine.with_unchecked_values(offsets)


def check_gaps(machine: Mechanism, angles: Mapping[str, float], location: str) -> None:
    """Raise ``InputError`` where two bodies of a track overlap at these angles (absolute, in rad)."""
    for track in machine.tracks:
        _offsets(track, _order(track, angles), angles, location)


def _order(track: Track, angles: Mapping[str, float]) -> list[TrackBody]:
    """Return the bodies of a track counter-clockwise, from its first one on."""
    first = angles[track.bodies[0].name]
    return sorted(track.bodies, key=lambda b: (angles[b.name] - first) % (2 * math.pi))


def _offsets(track: Track, order: Sequence[TrackBody], angles: Mapping[str, float], location: str) -> list[float]:
    """Return the angles to add to the difference of two neighbours' angles to obtain the gap between them.

    Whole turns by which the next body lies ahead, less the angle that both fill; a clearance where they just touch.
    """
    offsets = []
    for a, b in _neighbours(order):
        apart, width = angles[b.name] - angles[a.name], angular_width(a, b)
        ahead = apart % (2 * math.pi)
        gap = ahead - width
        if gap < -_PLAY:
            hint = f"their centres must be at least {math.degrees(width):.4g} degrees apart"
            sentence = f"{a.name!r} and {b.name!r} of the track {track.name!r} overlap: {hint}"
            raise InputError(f"{location}.{b.name}", math.degrees(angles[b.name]), sentence)
        offsets.append(2 * math.pi * round((ahead - apart) / (2 * math.pi)) - width + (_PLAY - gap if gap < _PLAY else 0.0))
    return offsets


def starts(bodies: Sequence[TrackBody]) -> dict[str, float]:
    """Return the start angles of a track's bodies from the body turned about: as given, evenly spaced without any."""
    if any(b.start is not None for b in bodies):
        return {b.name: b.start or 0.0 for b in bodies}
    return even_start_angles(bodies)


def even_start_angles(bodies: Sequence[TrackBody]) -> dict[str, float]:
    """Return angles at which the bodies of a track are evenly spaced, in the given order."""
    return {b.name: k * 2 * math.pi / len(bodies) for k, b in enumerate(bodies)}
