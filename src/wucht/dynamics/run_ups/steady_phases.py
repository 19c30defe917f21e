"""A machine at a steady speed: its bodies in steady phases, held, or at the start of a coast-down."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from wucht.analysis.configurations.configuration import Configuration, RunningConfigurations
from wucht.analysis.configurations.steady_branches import SteadyBranch, steady_branches
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.vibration import ForcedVibration
from wucht.dynamics.run_ups.initial_state import angles_in, format_phases, initial_state, start_gives
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import machine_at_speed, sense_of
from wucht.machines.tracks import arrange_contacts

HELD_HINT = "study.bodies = 'held' holds them at the phases of study.start"


@dataclass(frozen=True)
class Piece:
    """A part of a branch in which the configuration has one name: masks of where it exists (N,), and is stable (N,).

    overlapping: bodies of a track would overlap.
    """

    branch: int
    label: str
    inside: np.ndarray
    stable: np.ndarray
    overlapping: bool


@dataclass(frozen=True)
class SteadyPhases:
    """Positions of the bodies while all turn at one speed.

    machine: after its schedules. angles: absolute, of its bodies (n,), in rad; forced_vibration: with the bodies there.
    torques, branches: of balancing bodies in the steady phases that belong to each speed; None and empty where they are held,
    or there are none. configurations: of several rotors, those in which they run synchronously, stable or not; None where
    they are held. Then there is a branch for each stable one, or for that nearest to the start, which holds its phases.
    held_reason: why bodies are held by default.
    """

    machine: Machine
    angles: np.ndarray
    forced_vibration: ForcedVibration
    torques: SteadyTorques | None = None
    branches: tuple[SteadyBranch, ...] = ()
    configurations: tuple[Configuration, ...] | None = None
    held_reason: str = ""

    @classmethod
    def of(
        cls,
        machine: Machine,
        start: Mapping[str, Any],
        bodies: Literal["steady", "held"] | None,
        watch: Callable[[], None] | None = None,
    ) -> SteadyPhases:
        """Return the bodies as requested, by default in steady phases where these are known; else as at the start.

        start: as in ``initial_state``; speeds and the carrier's start do not matter, and phases of several rotors select one of
        their stable configurations. watch: called often while these are searched. Raises ``InputError`` where the start does
        not fit the machine, where bodies of a track overlap, where steady phases are not known, and where the carrier is not
        linear.
        """
        steady = machine.at(machine.breakpoints[-1])
        by_name, reason = angles_in(steady, initial_state(steady, start)), ""
        if bodies != "held" and (len(machine.rotors) > 1 or any(b.about is not None for b in machine.bodies)):
            try:
                return cls._with_steady_phases(machine, steady, start, watch)
            except InputError as error:
                if bodies == "steady":
                    explanation = f"not possible here: {error.explanation}; {HELD_HINT}"
                    raise InputError("study.bodies", bodies, explanation, code=error.code) from None
                reason = error.explanation
        arrange_contacts(steady, by_name)
        angles = np.array(list(by_name.values()))
        return cls(steady, angles, ForcedVibration.of(steady, angles), held_reason=reason)

    @classmethod
    def _with_steady_phases(
        cls, machine: Machine, steady: Machine, start: Mapping[str, Any], watch: Callable[[], None] | None
    ) -> SteadyPhases:
        """Return the bodies in steady phases. Raises ``InputError`` where these are not known."""
        angles = np.zeros(len(steady.bodies))
        if len(machine.rotors) == 1:
            return cls(steady, angles, ForcedVibration.of(steady, angles), *steady_branches(machine))
        if watch is not None:
            watch()  # the equations that are searched take a while, too
        running, stable = stable_configurations(machine, start, watch=watch)
        configurations = tuple(sorted((*running.unstable, *stable), key=lambda c: abs(c.speed)))
        branches = tuple(
            SteadyBranch(running.torques, c.state.phases, configuration_label=label)
            for c, label in zip(stable, configuration_labels(stable), strict=True)
        )
        if not stable:
            angles = np.array(list(angles_in(steady, initial_state(steady, start)).values()))
        return cls(steady, angles, ForcedVibration.of(steady, angles), running.torques, branches, configurations)

    @property
    def is_free(self) -> bool:
        """True if nothing but the machine decides the phases of its bodies."""
        return self.torques is not None or len(self.machine.bodies) == 1

    @property
    def curves(self) -> list[ForcedVibration]:
        """The vibration of each branch; a single one for bodies that are held."""
        return [replace(self.forced_vibration, phase_law=branch.machine_phases) for branch in self.branches] or [
            self.forced_vibration
        ]

    def grid(self, speeds: np.ndarray) -> np.ndarray:
        """Return a grid of speeds (N,), signed, with those at which branches end."""
        ends = [sense_of(self.machine, self.machine.rotor) * b.ends(np.unique(np.abs(speeds))) for b in self.branches]
        inside = np.concatenate([speeds, *ends])
        return np.unique(inside[(inside >= speeds.min()) & (inside <= speeds.max())])

    def pieces(self, speeds: np.ndarray) -> list[Piece]:
        """Return the configurations over speeds (N,), positive in the main rotor's sense of rotation; none of held bodies."""
        pieces: list[Piece] = []
        for k, branch in enumerate(self.branches):
            labels, stable = branch.labels(speeds), branch.stable(speeds)
            for label in dict.fromkeys(labels[labels != ""].tolist()):
                inside = labels == label
                pieces.append(Piece(k, label, inside, stable & inside, branch.overlapping))
        return pieces

    @property
    def assumptions(self) -> list[str]:
        """The phases of bodies, as statements; empty for a single body."""
        if self.configurations is not None:
            return self._rotor_assumptions()
        if self.branches:
            return ["balancing bodies in the steady phases at each speed, stable or unstable by the averaged equations"]
        angles = dict(zip((b.name for b in self.machine.bodies), self.angles.tolist(), strict=True))
        phases = {b.name: angles[b.name] - angles[b.about] for b in self.machine.bodies if b.about is not None}
        rotors = {r.name: angles[r.name] for r in self.machine.rotors}
        return [
            *([f"balancing bodies held at {format_phases(phases)} relative to their rotor"] if phases else []),
            *([f"rotors held at {format_phases(rotors)}, turning at one speed"] if len(rotors) > 1 else []),
        ]

    def _rotor_assumptions(self) -> list[str]:
        """The state in which several rotors run."""
        if not self.branches:
            return ["rotors at the phases of the start, turning at one speed: no synchronous configuration is stable"]
        configurations = [f"{label} at {speed:.5g}{_unit(self.machine)}" for label, speed in self.running_speeds.items()]
        phases = "its phases are" if len(configurations) == 1 else "the phases of each are"
        return [
            f"rotors in the stable synchronous configuration {', or '.join(configurations)} (averaged equations); "
            f"{phases} held over the speed"
        ]

    @property
    def running_speeds(self) -> dict[str, float]:
        """The speed at which several rotors run in each stable configuration, by label."""
        speeds = {tuple(c.state.phases): abs(c.speed) for c in self.configurations or ()}
        return {b.configuration_label: speeds[tuple(b.solution)] for b in self.branches if isinstance(b.solution, np.ndarray)}

    def list_labels(self, labels: Sequence[str]) -> str:
        """Return different labels of configurations as a list; those of several rotors contain commas themselves."""
        separator = ", " if self.configurations is None else " or "
        return separator.join(dict.fromkeys(label for label in labels if label))

    @property
    def warnings(self) -> list[str]:
        """Sentences on what the steady vibration of a linear carrier omits."""
        prescribed_motion = "the prescribed motion of the carrier is left out: only the vibration by the unbalance is computed"
        sliders = "sliders are held where their springs are free of force: their unbalance does not grow with the speed"
        switchable = "switchable pendulums are treated as closed, at any speed: study.kind = 'activation' shows them open"
        balancing = any(b.about is not None for b in self.machine.bodies)
        subject = "balancing bodies are held, as their" if balancing else "rotors are at the phases of the start, as"
        held_bodies = f"{subject} steady phases are not computed: {self.held_reason}"
        inside = [x.name == x.about for x in self.machine.sliders]
        left_out = {
            prescribed_motion: self.machine.shaken_coordinate is not None,
            sliders: not all(inside),
            switchable: any(inside),
        }
        left_out[held_bodies] = bool(self.held_reason)
        of_steady = [f"contacts on the track {t.name} are left out" for t in self.machine.tracks]
        of_steady += [f"{b.name} is taken as released" for b in self.machine.bodies if b.release is not None]
        return [*(sentence for sentence, applies in left_out.items() if applies), *(of_steady if self.branches else [])]


_PAIR = ("psi", "delta")


def phases_at_start(machine: Machine, start: Mapping[str, Any]) -> dict[str, float]:
    """Return the phases that a start gives to bodies other than the main rotor, in rad, as those of a configuration.

    Of a balancing body: relative to its rotor. Of another rotor: relative to the main one, each in its sense.
    """
    angles, senses = angles_in(machine, initial_state(machine, start)), {b.name: sense_of(machine, b) for b in machine.bodies}
    main, pair = machine.rotor.name, any(key in start for key in _PAIR)
    phases = dict[str, float]()
    for b in machine.bodies:
        is_given = start_gives(start, b.name, "angle")
        if b.about is not None and (is_given or pair):
            phases[b.name] = angles[b.name] - angles[b.about]
        elif b.about is None and b.name != main and (is_given or start_gives(start, main, "angle")):
            phases[b.name] = senses[b.name] * angles[b.name] - senses[main] * angles[main]
    return phases


def stable_configurations(
    machine: Machine,
    start: Mapping[str, Any],
    speeds: tuple[float, float] | None = None,
    watch: Callable[[], None] | None = None,
) -> tuple[RunningConfigurations, tuple[Configuration, ...]]:
    """Return the configurations of several rotors, and the stable ones: one of them where the start gives phases.

    speeds, watch: of the search, as for ``RunningConfigurations.of``. Raises ``InputError`` where there are no averaged
    equations, or nothing drives the machine.
    """
    running = RunningConfigurations.of(machine, speeds, watch)
    phases = phases_at_start(machine.at(machine.breakpoints[-1]), start)
    return running, (running.nearest(phases),) if phases and running.stable else running.stable


def configuration_labels(configurations: Sequence[Configuration]) -> list[str]:
    """Return the label of each configuration of several rotors: its name where no other has it, else its phases."""
    names = [c.name for c in configurations]
    return [c.name if c.name is not None and names.count(c.name) == 1 else format_phases(c.phases) for c in configurations]


@dataclass(frozen=True)
class BodyPhases:
    """The phases of balancing bodies at the start.

    to_rotor: the angle of each to the rotor, in the rotor's sense; empty where ``study.start`` and the machine state it.
    label: the name of the steady configuration; other_labels: those of the other stable ones. held_reason: why they are
    not in steady phases by default.
    """

    to_rotor: Mapping[str, float]
    label: str = ""
    other_labels: tuple[str, ...] = ()
    held_reason: str = ""

    @classmethod
    def of(
        cls, machine: Machine, start: Mapping[str, Any], speed: float, bodies: Literal["steady", "held"] | None
    ) -> BodyPhases:
        """Return the phases of a machine without its drives at the speed of its main rotor, signed.

        Raises ``InputError`` if steady phases are requested that are not known, or if ``start`` has the bodies elsewhere.
        """
        balancing = [b for b in machine.bodies if b.about is not None]
        start_keys = [name for name in (*(b.name for b in balancing), *_PAIR) if name in start]
        if bodies == "held" or not balancing or (start_keys and bodies is None):
            return cls({})
        if start_keys:
            raise InputError(
                "study.bodies",
                bodies,
                f"not allowed: study.start.{start_keys[0]} places the bodies; {HELD_HINT}",
                code="not-allowed",
            )
        try:
            return cls._steady(machine, speed)
        except InputError as error:
            if bodies == "steady":
                raise InputError(
                    "study.bodies", bodies, f"not possible here: {error.explanation}; {HELD_HINT}", code="no-stable-phases"
                ) from None
            return cls({}, held_reason=error.explanation)

    @classmethod
    def _steady(cls, machine: Machine, speed: float) -> BodyPhases:
        """Return the stable phases, compensating ones before those in line. Raises ``InputError`` if there are none."""
        locked_body = next((b.name for b in machine.bodies if b.about is not None and b.release is not None), None)
        if locked_body is not None:
            raise InputError("machine.bodies", None, f"{locked_body} is locked to its rotor until it is released")
        at, speeds = machine.at(0.0).with_fields(schedules=()), np.array([abs(speed)])
        torques, branches = steady_branches(machine_at_speed(at, speed))
        stable = [branch for branch in branches if branch.stable(speeds)[0] and not branch.overlapping]
        if not stable:
            reason = f"none of their steady phases at {abs(speed):.4g}{_unit(machine)} is stable"
            raise InputError("machine.bodies", None, f"{reason} by the averaged equations")
        names, phases = [b.name for b in at.bodies], stable[0].machine_phases(speeds)[0][:, 0]
        alpha = dict(zip(names, phases.tolist(), strict=True))
        relative_angles = {b.name: alpha[b.name] - alpha[b.about] for b in at.bodies if b.about is not None}
        senses = dict(zip(torques.names, torques.senses.tolist(), strict=True))
        return cls({name: senses[name] * angle for name, angle in relative_angles.items()}, *_labels(stable, speeds))

    def assumptions(self, phases: Mapping[str, float]) -> list[str]:
        """Return the start of the balancing bodies as statements; none without phases (rad, relative to their rotor)."""
        if not phases:
            return []
        if not self.to_rotor:
            return [f"balancing bodies start at {format_phases(phases)} relative to their rotor"]
        count = len(self.other_labels)
        alternatives = f"; {count} other{'s' if count > 1 else ''} ({', '.join(self.other_labels)}) stable too" if count else ""
        return [
            f"balancing bodies start in steady phases: {self.label}, {format_phases(phases)} relative to "
            f"their rotor{alternatives}"
        ]


def _labels(stable: list[SteadyBranch], speeds: np.ndarray) -> tuple[str, tuple[str, ...]]:
    label, *other_labels = (str(branch.labels(speeds)[0]) for branch in stable)
    return label, tuple(other_labels)


def _unit(machine: Machine) -> str:
    return f" {machine.units.speed}" if machine.units.speed else ""
