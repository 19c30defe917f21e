"""What a machine is built for: a screen, a drum, a fan or a rig, as far as its parts tell."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wucht.machines.machine import Machine

_BALANCING = ("pendulum", "roller", "slider", "switchable-pendulum")


class Purpose(StrEnum):
    """Purposes of machines, as in ``[machine] purpose``."""

    SCREEN = "screen"
    DRUM = "drum"
    FAN = "fan"
    RIG = "rig"


def purpose_of_parts(machine: Machine) -> Purpose | None:
    """Return what a machine is built for.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    Purpose or None
        A screen: several unbalanced rotors on a carrier, or one with material on it. A rig: a rotor with a single pendulum,
        which cannot compensate it steadily. A drum: a rotor with other balancing bodies. A fan: a rotor alone whose load grows
        with the square of its speed. None: none of these.
    """
    rotors = [body for body in machine.bodies if body.about is None]
    kinds_about = [body.kind for body in machine.bodies if body.about is not None]
    kinds_about += [slider.kind for slider in machine.sliders if slider.name != slider.about]
    kinds = [part.kind for part in machine.parts]
    balancing = [kind for kind in kinds_about if kind in _BALANCING]
    if "material-layer" in kinds or (len(rotors) > 1 and not kinds_about):
        return Purpose.SCREEN
    if len(rotors) != 1:
        return None
    if balancing == ["pendulum"]:
        return Purpose.RIG
    if balancing:
        return Purpose.DRUM
    return Purpose.FAN if "quadratic" in kinds else None
