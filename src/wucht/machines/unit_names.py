"""The units in which a machine's results are."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """The units of time, length, torque, power, energy, force and unbalance, all empty for a dimensionless machine."""

    time: str = "s"
    length: str = "m"
    torque: str = "N m"
    power: str = "W"
    energy: str = "J"
    force: str = "N"
    speed: str = "rad/s"


DIMENSIONLESS = Units("", "", "", "", "", "", "")
