"""The contacts of balls on a track in a run: how far these overlap, as a finite frequency allows, and what that changes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES
from wucht.dynamics.work import Work
from wucht.machines.tracks import gaps

_DEEP = math.radians(1.0)  # on the track: with this overlap balls stand elsewhere than rigid ones
_STIFFER = 2.0  # times the frequency: contacts that are four times as stiff


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


@dataclass(frozen=True)
class ContactCheck:
    """A run, and the same run with contacts of another stiffness.

    motion: the one that is reported. reference: the other one. is_stiffer: the contacts of the reported one are.
    """

    motion: Motion
    reference: Motion
    is_stiffer: bool

    @property
    def amplitude_change(self) -> float | None:
        """The difference of the largest amplitudes of both runs, as a share of the reported one."""
        largest = self.motion.observation.largest
        return abs(self.reference.observation.largest - largest) / largest if largest else None

    @property
    def residual_change(self) -> float | None:
        """The difference of the residual shares of the unbalance at the end; None where one of them is not known."""
        residuals = self.motion.verdict.residual, self.reference.verdict.residual
        return None if residuals[0] is None or residuals[1] is None else abs(residuals[1] - residuals[0])

    def warning(self) -> str:
        """Return a sentence where the outcome depends on the stiffness, else nothing."""
        if not self.is_stiffer:
            return ""
        return (
            f"the outcome depends on the stiffness of the contacts: with that of the machine it is "
            f"{str(self.reference.verdict.outcome)!r}; this run has contacts four times as stiff, and the outcome "
            f"{str(self.motion.verdict.outcome)!r}; a larger contact_frequency in [machine.tracks] shows that of rigid bodies"
        )


def check_contacts(motion: Motion, work: Work) -> ContactCheck | None:
    """Run a machine up again with contacts four times as stiff, and report the stiffer run if its outcome differs.

    Returns None for a run in which no bodies touched, or that has failed. Softer contacts are closer to none at all: where the
    outcome differs it is not that of rigid bodies. What one of both runs leaves open is no difference.
    """
    contacts = track_contacts(motion)
    if not any(c.overlap for c in contacts.values()) or motion.trajectory.failure or motion.trajectory.is_interrupted:
        return None
    machine = motion.case.machine
    names = [track.symbol("contact_frequency").name for track in machine.tracks]
    stiffer = machine.with_unchecked_values({name: _STIFFER * machine.values[name] for name in names})
    case = RunUpCase.from_state(stiffer, motion.model.initial, replace(motion.case.settings, model="full"))
    *_, (reference,) = run_up(case, work)
    outcomes = {motion.verdict.outcome, reference.verdict.outcome}
    if len(outcomes) == 1 or outcomes.intersection(OPEN_OUTCOMES):
        return ContactCheck(motion, reference, is_stiffer=False)
    return ContactCheck(reference, motion, is_stiffer=True)
