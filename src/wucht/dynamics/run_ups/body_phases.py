"""Where the balancing bodies of a coast-down start: in the steady phases of the speed, or where ``study.start`` has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from wucht.analysis.configurations.steady_branches import SteadyBranch, steady_branches
from wucht.analysis.configurations.steady_machine import turning
from wucht.dynamics.run_ups.initial_state import listed
from wucht.dynamics.run_ups.steady_phases import HELD
from wucht.errors import InputError
from wucht.machines.machine import Machine

_PAIR = ("psi", "delta")


@dataclass(frozen=True)
class BodyPhases:
    """The phases of balancing bodies at the start.

    to_rotor: the angle to the rotor that each is given, in its own sense; empty where they are where ``study.start`` and the
    machine say. label: what the steady configuration is called; others: what the other stable ones are. why_held: why they are
    not in steady phases, where nobody asked for that.
    """

    to_rotor: Mapping[str, float]
    label: str = ""
    others: tuple[str, ...] = ()
    why_held: str = ""

    @classmethod
    def of(
        cls, machine: Machine, start: Mapping[str, Any], speed: float, bodies: Literal["steady", "held"] | None
    ) -> BodyPhases:
        """The phases of a machine without its drives at the speed of its main rotor, signed.

        Raises ``InputError`` where steady phases are asked for that are not known, or where ``start`` has the bodies elsewhere.
        """
        balancing = [b for b in machine.bodies if b.about is not None]
        given = [name for name in (*(b.name for b in balancing), *_PAIR) if name in start]
        if bodies == "held" or not balancing or (given and bodies is None):
            return cls({})
        if given:
            raise InputError(
                "study.bodies",
                bodies,
                f"not allowed: study.start.{given[0]} says where the bodies are; {HELD}",
                code="not-allowed",
            )
        try:
            return cls._steady(machine, speed)
        except InputError as error:
            if bodies == "steady":
                raise InputError(
                    "study.bodies", bodies, f"not known here: {error.allowed}; {HELD}", code="no-stable-phases"
                ) from None
            return cls({}, why_held=error.allowed)

    @classmethod
    def _steady(cls, machine: Machine, speed: float) -> BodyPhases:
        """The stable ones, those that compensate before those in line. Raises ``InputError`` where there are none."""
        locked = next((b.name for b in machine.bodies if b.about is not None and b.release is not None), None)
        if locked is not None:
            raise InputError("machine.bodies", None, f"{locked} is locked to its rotor until it is released")
        at, speeds = machine.at(0.0).changed(schedules=()), np.array([abs(speed)])
        torques, found = steady_branches(turning(at, speed))
        stable = [branch for branch in found if branch.stable(speeds)[0] and not branch.overlapping]
        if not stable:
            why = f"none of their steady phases at {abs(speed):.4g}{_unit(machine)} is stable"
            raise InputError("machine.bodies", None, f"{why} by the averaged equations")
        names, phases = [b.name for b in at.bodies], stable[0].placed(speeds)[0][:, 0]
        alpha = dict(zip(names, phases.tolist(), strict=True))
        own = {b.name: alpha[b.name] - alpha[b.about] for b in at.bodies if b.about is not None}
        senses = dict(zip(torques.names, torques.senses.tolist(), strict=True))
        return cls({name: senses[name] * angle for name, angle in own.items()}, *_labels(stable, speeds))

    def assumed(self, phases: Mapping[str, float]) -> list[str]:
        """Where the balancing bodies start, as a statement; none where there are none. phases: to their rotor, in rad."""
        if not phases:
            return []
        if not self.to_rotor:
            return [f"balancing bodies start at {listed(phases)} to their rotor"]
        count = len(self.others)
        also = f"; {count} other{'s' if count > 1 else ''} ({', '.join(self.others)}) stable too" if count else ""
        return [f"balancing bodies start in steady phases: {self.label}, {listed(phases)} to their rotor{also}"]


def _labels(stable: list[SteadyBranch], speeds: np.ndarray) -> tuple[str, tuple[str, ...]]:
    label, *others = (str(branch.labels(speeds)[0]) for branch in stable)
    return label, tuple(others)


def _unit(machine: Machine) -> str:
    return f" {machine.units.speed}" if machine.units.speed else ""
