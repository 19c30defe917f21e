"""The synchronising torque of exciters: the vibration torque that passes between rotors, and how much more could pass.

At the common speed w the vibration gives rotor i the torque V_i = c_i + P_i(alpha) of ``analysis.configurations.torques``: c_i
by its own excitation, P_i by those of the others, which depends on the phases. I. I. Blekhman calls it the vibration moment
(Synchronization in Science and Technology, ASME Press, 1988). It makes up for the differences between what drives and losses
give the rotors, tau_i(w) + c_i, and the mean of these; so it is P_i less its mean that passes. It has a largest value over the
phases: for two rotors half the range of P_2 - P_1. The margin is the factor by which the differences could grow, at the same
speed, before no steady phases are left.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of, shaft_torques
from wucht.machines.parts.induction import Induction
from wucht.machines.structure import SPEED

_SMALL_MOTOR, _SLIP_OF_SMALL, _SLIP = 1e3, 0.3, 0.2  # W, and the tolerances of the slip below that power and from there on
_MOST_MOTORS = 6  # whose tolerances are combined in all ways
_EQUAL = 1e-9  # of the torques: a smaller difference is none
_ITERATIONS, _CLOSE = 30, 1e-12  # of Newton's method, and its last residual, of a torque that never passes
_LONGEST, _FINEST = 0.2, 1e-9  # rad, of the change of phases in a step, and share of the torque to which its end is found
_SPEEDS, _SLOWEST = 400, 0.5  # among which a common speed is searched, and the lowest of them, of the highest


@dataclass(frozen=True)
class SynchronisingTorque:
    """Rotors without bodies about them that turn at one speed.

    coupling: (w^4/2) a_ik (n, n) with a zero diagonal. torques: tau_i + c_i (n,). phases: alpha_i (n,), steady ones or others
    that lead to them without a change of stability. All in the senses of the rotors, in the order of ``machine.bodies``.
    """

    coupling: np.ndarray
    torques: np.ndarray
    phases: np.ndarray

    def passing(self, phases: np.ndarray) -> np.ndarray:
        """The torque that passes to each rotor (n,) at phases (n,)."""
        turning = np.exp(1j * phases)
        whole = -(turning * (self.coupling @ turning).conj()).imag
        return np.asarray(whole - whole.mean())

    def _slopes(self, phases: np.ndarray) -> np.ndarray:
        """The derivatives (n, n) of ``passing``."""
        change = (self.coupling * np.exp(-1j * (phases[:, None] - phases))).real
        change -= np.diag(change.sum(axis=1))
        return np.asarray(change - change.mean(axis=0))

    @property
    def needed(self) -> np.ndarray:
        """What has to pass to each rotor (n,)."""
        return np.asarray(self.torques.mean() - self.torques)

    @cached_property
    def moment(self) -> float:
        """The torque that has to pass: the most that a rotor gets, or gives. 0 of equal motors."""
        size = float(np.abs(self.needed).max())
        return size if size > _EQUAL * float(np.abs(self.torques).max()) else 0.0

    @cached_property
    def largest(self) -> float | None:
        """The largest torque that can pass, shared among the rotors as what has to pass; None where that is not found.

        Of equal motors it is that between the first rotor and all others.
        """
        now, first = self.passing(self.phases), np.arange(len(self.torques)) == 0
        neutral = self._follow(self.phases, now, -now)
        if neutral.share < 1:
            return None
        direction = self.needed / self.moment if self.moment else np.where(first, 1.0, -1 / (len(first) - 1))
        return self._follow(neutral.phases, np.zeros(len(first)), direction * self._upper_limit).share * self._upper_limit

    @property
    def margin(self) -> float | None:
        """The largest torque that can pass over that which has to: infinite of equal motors, below 1 without steady phases."""
        if self.largest is None:
            return None
        return self.largest / self.moment if self.moment else math.inf

    @cached_property
    def _upper_limit(self) -> float:
        """A torque that never passes."""
        return float(2 * np.abs(self.coupling).sum()) or 1.0

    def _steady_phases(self, right: np.ndarray, phases: np.ndarray) -> np.ndarray | None:
        """The phases (n,) at which torques (n,) pass, by Newton's method from others near by; None without any."""
        at = phases.copy()
        for _ in range(_ITERATIONS):
            rest = (self.passing(at) - right)[1:]
            if np.abs(rest).max() <= _CLOSE * self._upper_limit:
                return at
            try:
                at[1:] -= np.linalg.solve(self._slopes(at)[1:, 1:], rest)
            except np.linalg.LinAlgError:
                return None
            if not np.abs(at - phases).max() <= _LONGEST:
                return None
        return None

    def _follow(self, phases: np.ndarray, begin: np.ndarray, rise: np.ndarray) -> _Course:
        """Let the torques that pass rise from those at phases (n,), as far as there are phases at which they do."""
        share, step, at = 0.0, 1.0, phases
        while share < 1.0 and step > _FINEST * max(share, _FINEST):
            step = min(step, 1.0 - share)
            following = self._steady_phases(begin + (share + step) * rise, at)
            if following is None:
                step /= 2
            else:
                share, at, step = share + step, following, 2 * step
        return _Course(at, share)


@dataclass(frozen=True)
class _Course:
    """How far torques could rise: the last phases (n,), and the share of the rise."""

    phases: np.ndarray
    share: float


@dataclass(frozen=True)
class SynchronisationMargin:
    """How far exciters are from the end of their synchronism. Torques in the machine's unit.

    largest: that can pass between the rotors. passing: that has to. margin: their ratio, None where nothing has to pass, as
    between equal motors. within_tolerances: the least margin that the tolerances of the motors leave, None where not known.
    """

    largest: float
    passing: float
    margin: float | None
    within_tolerances: float | None

    @classmethod
    def of(cls, machine: Machine, speed: float, phases: Mapping[str, float]) -> SynchronisationMargin | None:
        """The margin in steady phases of the other rotors to the main one; None of a machine without exciters."""
        exciters = Exciters.of(machine)
        within = None if exciters is None else margin_within_tolerances(machine, phases)
        return None if exciters is None else cls._from_torque(exciters.at(abs(speed), phases), within)

    @classmethod
    def without_drive(
        cls, machine: Machine, rotor: str, speed: float, phases: Mapping[str, float]
    ) -> SynchronisationMargin | None:
        """The margin that drags a rotor along whose drives have no supply, from a common speed and phases before.

        None of a machine without exciters, and where the other drives cannot keep all rotors turning.
        """
        exciters = Exciters.of(machine, rotor)
        common = None if exciters is None else exciters.common_speed(abs(speed), phases)
        return None if exciters is None or common is None else cls._from_torque(exciters.at(common, phases), None)

    @classmethod
    def _from_torque(cls, torque: SynchronisingTorque, within: float | None) -> SynchronisationMargin | None:
        if torque.largest is None or torque.margin is None:
            return None
        return cls(torque.largest, torque.moment, torque.margin if torque.moment else None, within)


@dataclass(frozen=True)
class Exciters:
    """Rotors without bodies about them, of which at least two have drives, on a linear carrier.

    torques: functions of the speed, of each rotor, in its sense.
    """

    names: tuple[str, ...]
    vibration: Vibration
    torques: Sequence[Callable[[np.ndarray], np.ndarray]]

    @classmethod
    def of(cls, machine: Machine, undriven: str | None = None) -> Exciters | None:
        """The exciters of a machine; None of a machine without such. undriven: a rotor whose drives have no supply."""
        if not has_exciters(machine):
            return None
        try:
            vibration = Vibration.of(machine)
        except WuchtError:
            return None
        torques = [_torque_of(machine, k, is_driven=b.name != undriven) for k, b in enumerate(machine.bodies)]
        return cls(tuple(b.name for b in machine.bodies), vibration, torques)

    def _influence(self, speeds: np.ndarray) -> np.ndarray:
        excitation = self.vibration.excitation
        response = self.vibration.displacement(speeds[:, None, None], excitation.T)
        return np.asarray(speeds[:, None, None] ** 4 / 2 * (excitation.conj() @ response))

    def at(self, speed: float, phases: Mapping[str, float]) -> SynchronisingTorque:
        """The torque at a common speed, a magnitude, and phases of the other rotors to the main one."""
        w = np.array([speed])
        influence = self._influence(w)[0]
        torques = np.array([float(torque(w)[0]) for torque in self.torques]) + np.diag(influence).imag
        at = np.array([phases.get(name, 0.0) for name in self.names])
        return SynchronisingTorque(influence - np.diag(np.diag(influence)), torques, at)

    def common_speed(self, highest: float, phases: Mapping[str, float]) -> float | None:
        """The fastest speed up to one at which all torques together balance in these phases; None where they do not."""
        speeds = np.linspace(_SLOWEST * highest, highest, _SPEEDS)
        turning = np.exp(1j * np.array([phases.get(name, 0.0) for name in self.names]))
        brakes = (turning * (self._influence(speeds) @ turning).conj()).imag.sum(axis=1)
        surplus = sum(torque(speeds) for torque in self.torques) - brakes
        falls = np.flatnonzero((surplus[:-1] > 0) & (surplus[1:] <= 0))
        if not len(falls):
            return None
        k = int(falls[-1])
        return float(speeds[k] + (speeds[k + 1] - speeds[k]) * surplus[k] / (surplus[k] - surplus[k + 1]))


def has_exciters(machine: Machine) -> bool:
    """True if at least two rotors have drives, no speed is enforced, and no bodies turn about a rotor or slide in it."""
    driven = {machine.rotor_of(machine.body(d.on)).name for d in machine.drives}
    is_plain = len(machine.bodies) == len(machine.rotors) and not machine.sliders and machine.shaken_coordinate is None
    return is_plain and len(driven) > 1 and all(b.coordinate.prescribed_velocity is None for b in machine.bodies)


def margin_within_tolerances(machine: Machine, phases: Mapping[str, float]) -> float | None:
    """The least margin for motors whose slips deviate by their tolerances, each to either side; None where not known.

    IEC 60034-1:2010, table 20: 20 per cent of the guaranteed slip, of motors below 1 kW 30 per cent. With another resistance of
    the rotor each torque, that of the breakdown too, belongs to a slip that is as many times larger. phases: steady ones, in
    which the common speed is that of all torques together. All drives have to be induction motors with a nameplate.
    """
    plates = {d: d.nameplate for d in machine.drives if isinstance(d, Induction) and d.nameplate is not None}
    if not has_exciters(machine) or not len(machine.drives) == len(plates) <= _MOST_MOTORS:
        return None
    highest, margins = max(abs(d.reduced_synchronous_speed() or 0.0) for d in plates), list[float]()
    for signs in itertools.product((-1, 1), repeat=len(plates)):
        values = dict[str, float]()
        for sign, (drive, plate) in zip(signs, plates.items(), strict=True):
            factor = 1 + sign * (_SLIP_OF_SMALL if plate.power < _SMALL_MOTOR else _SLIP)
            keys = (f"{drive.path}.rotor_resistance", f"{drive.path}.standstill_resistance")
            values |= {key: factor * machine.values[key] for key in keys if key in machine.values}
        exciters = Exciters.of(machine.with_unchecked_values(values))
        speed = None if exciters is None else exciters.common_speed(highest, phases)
        margin = None if exciters is None or speed is None else exciters.at(speed, phases).margin
        if margin is None:
            return None
        margins.append(margin)
    return min(margins)


def _torque_of(machine: Machine, index: int, *, is_driven: bool) -> Callable[[np.ndarray], np.ndarray]:
    """What drives and losses give a rotor over the speed, in its sense."""
    rotor = machine.bodies[index]
    sense, (drive, losses) = sense_of(machine, rotor), shaft_torques(machine, rotor)
    function = machine.function((drive if is_driven else 0) - losses, of=SPEED)
    return lambda w: np.asarray(sense * function(sense * w)[0] + np.zeros_like(w))
