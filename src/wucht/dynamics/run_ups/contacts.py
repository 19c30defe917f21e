"""The contacts of balls on a track in a run: how far they overlap, which their finite frequency allows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from wucht.dynamics.run_ups.run_up import Motion
from wucht.machines.tracks import gaps

_DEEP = math.radians(1.0)  # on the track: with this overlap balls stand elsewhere than rigid ones


@dataclass(frozen=True)
class TrackContacts:
    """The contacts of a track in a run.

    frequency: of the contacts, in rad/s. overlap: the largest, in rad on the track, None where the integrator does not observe
    it. radius: of the circle on which the bodies' centres run.
    """

    track: str
    frequency: float
    overlap: float | None
    radius: float

    def warning(self) -> str:
        """Return a sentence where bodies overlap so far that they would stand elsewhere if they were rigid, else nothing."""
        if self.overlap is None or self.overlap <= _DEEP:
            return ""
        return (
            f"bodies of the track {self.track!r} overlap by up to {math.degrees(self.overlap):.2g} degrees "
            f"({1e3 * self.overlap * self.radius:.2g} mm): contacts of {self.frequency:.4g} rad/s are too soft for phases and "
            f"amplitudes as of rigid bodies; a larger contact_frequency in [machine.tracks.{self.track}] makes them stiffer"
        )


def track_contacts(motion: Motion) -> Mapping[str, TrackContacts]:
    """Return the contacts of each track of a machine in a run of the full equations, by its name."""
    machine, locator, lowest = motion.case.machine, motion.compiled_system.locator, motion.trajectory.lowest_arguments
    if locator is None:
        return {}
    arguments = [s.argument for s in locator.segmentations]
    contacts = {}
    for track in machine.tracks:
        places = [arguments.index(gap) for gap in gaps(machine, track) if gap in arguments]
        if places:
            overlap = None if lowest is None else max(0.0, -float(lowest[places].min()))
            frequency = machine.values[track.symbol("contact_frequency").name]
            contacts[track.name] = TrackContacts(track.name, frequency, overlap, track.bodies[0].centre_radius())
    return contacts
