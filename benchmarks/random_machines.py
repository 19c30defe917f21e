"""Machines, starts and times drawn at random, of all parts and drives, within what could be built."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Document = dict[str, Any]
_STRUCTURES = 120  # machines that differ in more than numbers: each has to be compiled
_CARRIERS = ("x", "xy", "xy", "unequal", "xyr", "fixed", "shaken", "r")
_DRIVES = (
    "linear", "linear", "linear", "constant-torque", "constant-speed", "synchronous", "dc-separate", "dc-shunt", "dc-series",
    "induction", "table",
)  # fmt: skip
_PRESCRIBED = ("constant-speed", "synchronous")


@dataclass(frozen=True)
class Drawn:
    """A machine as a table, a start, and a time that an engineer might ask for."""

    machine: Document
    start: Document
    until: float


def drawn(number: int) -> Drawn:
    """The machine of a number: the same number gives the same machine."""
    return _Draw(np.random.default_rng(number % _STRUCTURES), np.random.default_rng(10_000 + number)).machine()


@dataclass
class _Draw:
    """kinds: draws the structure; numbers: all else. natural: frequency; free, stall: speed and torque of the drive."""

    kinds: np.random.Generator
    numbers: np.random.Generator
    total: float = field(init=False)
    natural: float = field(init=False)
    ratio: float = field(init=False)
    share: float = field(init=False)
    unbalance: float = field(init=False)
    free: float = field(init=False)
    stall: float = field(init=False)

    def __post_init__(self) -> None:
        self.total, self.natural, self.ratio = self.between(1, 20), self.between(15, 150), self.between(0.004, 0.15)
        self.share, self.unbalance = self.numbers.uniform(0.1, 0.7), self.total * self.between(2e-4, 5e-3)
        damping = 2 * self.ratio * self.total * self.natural
        peak = self.unbalance**2 * self.natural**3 / (2 * damping)  # of the vibration torque
        self.free, self.stall = self.natural * self.between(0.6, 4), peak * self.between(0.1, 6)

    def between(self, low: float, high: float) -> float:
        """A number, evenly over its logarithm."""
        return float(np.exp(self.numbers.uniform(math.log(low), math.log(high))))

    def one(self, *values: Any) -> Any:
        """One of some values, which decides the structure."""
        return values[int(self.kinds.integers(len(values)))]

    def angle(self) -> float:
        """An angle."""
        return float(self.numbers.uniform(-3, 3))

    def machine(self) -> Drawn:
        """All of it."""
        carrier, sense = self._carrier(), self.one(1.0, 1.0, 1.0, -1.0)
        kind, directions = self.one(*_DRIVES), carrier["directions"]
        drum = self._drum(directions)
        start: Document = {} if kind in _PRESCRIBED else {"drum": {"angle": self.angle()}}
        bodies, drives, loads = [drum], [self._drive(kind, sense, self.stall / self.free, self.free)], []
        for name in self.one("", "", "p", "pq", "pq", "pqr"):
            body = self._about_the_drum(name)
            bodies.append(body)
            start |= {} if body["kind"] == "slider" else {name: {"angle": self.angle()}}
        if self.one(*(False,) * 6, True) and directions in ("x", "xy", "xyr"):
            bodies.append(self._second(drum))
            slope, free = self.stall / self.free * self.between(0.7, 1.4), self.free * self.between(0.8, 1.2)
            drives = [drives[0] | {"on": "drum"}, self._drive("linear", self.one(1.0, -1.0), slope, free) | {"on": "second"}]
            start["second"] = {"angle": self.angle()}
        if kind not in _PRESCRIBED:
            loads = self._loads()
            if self.one(False, False, True):
                start["drum"]["speed"] = sense * self.free * self.numbers.uniform(0.2, 1.5)
        document = {"carrier": carrier, "bodies": bodies, "drives": drives, "loads": loads}
        return Drawn(document, start, self.between(20, 300) * 2 * math.pi / self.natural)

    def _carrier(self) -> Document:
        kind = self.one(*_CARRIERS)
        k, c = self.total * self.natural**2, 2 * self.ratio * self.total * self.natural
        gravity = {"gravity": self.one(0.0, 0.0, 9.81)}
        if kind == "fixed":
            return gravity | {"directions": "fixed"}
        if kind == "r":
            rotation = {"rotation_stiffness": 0.1 * k, "rotation_damping": 0.1 * c}
            return gravity | {"directions": "r", "inertia": self.total * 0.1} | rotation
        carrier = gravity | {"directions": kind, "mass": self.total * (1 - self.share), "stiffness": k, "damping": c}
        if kind == "xyr":
            rotation = {"rotation_stiffness": 0.05 * k * self.between(0.5, 4), "rotation_damping": 0.05 * c}
            return carrier | {"inertia": self.total * 0.05} | rotation
        if kind == "unequal":
            return carrier | {"directions": "xy", "stiffness": [k, k * self.between(1.1, 3)]}
        if kind == "shaken":
            amplitude = self.unbalance / self.total * self.between(0.3, 5)
            motion = {"direction": "x", "amplitude": amplitude, "frequency": self.natural * self.between(0.3, 2)}
            return carrier | {"directions": "xy", "motion": motion}
        return carrier

    def _drum(self, directions: str) -> Document:
        inertia = self.stall / self.natural**2 * self.between(3, 100)
        mass = self.total * self.share
        drum = {"kind": "rotor", "name": "drum", "mass": mass, "unbalance": self.unbalance}
        drum["inertia"] = inertia + self.unbalance**2 / mass * 1.001
        if self.one(False, True):
            drum["bearing_damping"] = self.stall / self.free * self.between(1e-3, 0.3)
        return drum | ({"position": [0.1, 0.05]} if directions in ("r", "xyr") else {})

    def _second(self, drum: Document) -> Document:
        second = drum | {"name": "second", "unbalance": self.unbalance * self.between(0.5, 2), "inertia": 4 * drum["inertia"]}
        return second | ({"position": [-0.1, 0.05]} if "position" in drum else {})

    def _about_the_drum(self, name: str) -> Document:
        arm, own = self.between(0.03, 0.15), self.unbalance * self.between(0.3, 2)
        kind, rate = self.one("pendulum", "pendulum", "roller", "slider"), self.natural * self.between(3e-3, 0.5)
        body = {"kind": kind, "name": name, "about": "drum", "mass": own / arm}
        if kind == "pendulum":
            return body | {"length": arm, "damping": own * arm * rate}
        if kind == "roller":
            return body | {
                "mass": own / (0.8 * arm),
                "track_radius": arm,
                "radius": 0.2 * arm,
                "damping": own * arm * rate * 0.04,
            }
        stiff = own / arm * (3 * max(self.free, self.natural)) ** 2 * self.between(1, 9)
        damping = own / arm * self.natural * self.between(0.1, 2)
        return body | {"radius": arm, "angle": self.angle(), "stiffness": stiff, "damping": damping}

    def _loads(self) -> list[Document]:
        kind, size = self.one(None, None, "viscous", "quadratic", "coulomb"), self.stall * self.between(0.01, 0.3)
        if kind is None:
            return []
        value = {"viscous": size / self.free, "quadratic": size / self.free**2, "coulomb": size}[kind]
        return [{"kind": kind, "on": "drum", "torque" if kind == "coulomb" else "coefficient": value}]

    def _drive(self, kind: str, sense: float, slope: float, free: float) -> Document:
        """A drive with about this slope and speed without load."""
        volts = math.sqrt(self.stall * free)
        speeds = np.linspace(0, 1.5 * free, 7)
        given: dict[str, Document] = {
            "linear": {"slope": slope, "no_load_speed": sense * free},
            "constant-torque": {"torque": sense * self.stall / 2},
            "constant-speed": {"speed": sense * free},
            "synchronous": {"frequency": free / (2 * math.pi), "pole_pairs": 1},
            "dc-separate": {"voltage": sense * math.sqrt(slope) * free, "armature_resistance": 1.0, "motor_constant": 1.0,
                            "flux": math.sqrt(slope)},
            "dc-shunt": {"voltage": volts, "armature_resistance": 1.0, "field_resistance": 1.0, "field_inductance": 1 / free,
                         "motor_constant": 1.0},
            "dc-series": {"voltage": volts, "armature_resistance": 0.7, "field_resistance": 0.3, "field_inductance": 1 / free,
                          "motor_constant": 1.0},
            "induction": {"voltage": volts / math.sqrt(3), "frequency": free / (2 * math.pi), "pole_pairs": 1,
                          "stator_resistance": 0.2, "rotor_resistance": 0.3, "stator_reactance": 0.4, "rotor_reactance": 0.4},
            "table": {"points": [[float(w), float(self.stall * (1 - (w / free) ** 3))] for w in speeds]},
        }  # fmt: skip
        return {"kind": kind} | given[kind]
