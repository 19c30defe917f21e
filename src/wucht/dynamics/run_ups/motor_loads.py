"""The load of motors whose rated data are known: in operation, and over a start, by torque and by the heat of the current."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.run_ups.drive_losses import drive_torque
from wucht.dynamics.verdicts.observation import motion_of
from wucht.fatigue.bearing_life import mean_over_time
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Drive
from wucht.machines.parts.dc_separate import DCSeparate
from wucht.machines.parts.induction import Induction
from wucht.machines.structure import SPEED
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

_TEST_CURRENT = 7.2  # times the rated one
# s: the times that relays of each class wait at that current at least, from cold (IEC 60947-4-1:2009, table 3).
_LEAST_TRIPPING_TIMES = {"5": 0.5, "10": 4.0, "20": 6.0, "30": 9.0}
_SLIPS = np.geomspace(1e-6, 3.0, 400)  # at which the current is computed, of either sign


@dataclass(frozen=True)
class MotorLoad:
    """The load of a motor, in its own torque and speed before a transmission. Torques in N m.

    torque_share, power_share: mean torque and power in operation over the rated ones. starting_torque: root of the mean square
    over the start; starting_share: over the rated torque. heat: I^2 t over the start in units of the rated current squared, in
    s, None where the current is not known.
    """

    torque_share: float
    power_share: float
    starting_torque: float
    starting_share: float
    heat: float | None

    @property
    def trip_class(self) -> str | None:
        """The fastest class of overload relays, set to the rated current, that lets the start pass from cold; None without.

        A relay heats as I^2 t without losing heat, so that it waits longer in truth: at 7.2 times its current it does not trip
        before a least time (IEC 60947-4-1:2009, table 3).
        """
        if self.heat is None:
            return None
        heats = {name: _TEST_CURRENT**2 * time for name, time in _LEAST_TRIPPING_TIMES.items()}
        return next((name for name, heat in heats.items() if self.heat < heat), None)


def rated_torque(drive: Drive) -> float | None:
    """The rated torque of a motor in N m, None of one without a nameplate."""
    if isinstance(drive, Induction) and drive.nameplate is not None:
        return drive.nameplate.torque
    if isinstance(drive, DCSeparate) and drive.nameplate is not None:
        return drive.nameplate.shaft_torque
    return None


def torque_share(machine: Machine, drive: Drive, speed: float) -> float | None:
    """The torque of a motor at a speed of the body over its rated one; None without a nameplate."""
    at_rating = rated_torque(drive)
    if at_rating is None:
        return None
    torque = machine.function(drive.torque(SPEED), of=SPEED, modules="math")
    return abs(float(torque(_ratio(machine, drive) * speed)[0])) / at_rating


def _ratio(machine: Machine, drive: Drive) -> float:
    return 1.0 if drive.transmission is None else machine.values[f"{drive.path}.transmission.ratio"]


def motor_loads(machine: Machine, motion: Trajectory, window: tuple[float, float], start_end: float) -> dict[str, MotorLoad]:
    """Return the loads of the motors with a nameplate, by the body that they drive.

    window: of operation. start_end: time at which the start is over.
    """
    rated_torques = {d: at_rating for d in machine.drives if (at_rating := rated_torque(d)) is not None}
    if not rated_torques:
        return {}
    torques = Evaluator.of(machine.system, [drive_torque(machine, d) for d in rated_torques], [d.path for d in rated_torques])
    rows, time = torques(motion.time, motion.states, motion.final_parameter_values), motion.time
    if window[1] <= window[0] or start_end <= time[0]:
        return {}
    loads = dict[str, MotorLoad]()
    for drive, of_rated in rated_torques.items():
        ratio = _ratio(machine, drive)
        speed = ratio * _speed(machine, drive, motion)
        torque = np.broadcast_to(rows[drive.path], time.shape) / ratio
        mean, power = (mean_over_time(time, x, *window) for x in (torque, torque * speed))
        square = math.sqrt(mean_over_time(time, torque**2, time[0], start_end))
        currents, heat = _current_ratio(machine, drive, speed), None
        if currents is not None:
            heat = (start_end - time[0]) * mean_over_time(time, currents**2, time[0], start_end)
        rated_power = of_rated * _rated_speed(drive)
        loads[drive.on] = MotorLoad(abs(mean) / of_rated, power / rated_power, square, square / of_rated, heat)
    return loads


def _rated_speed(drive: Drive) -> float:
    assert isinstance(drive, Induction | DCSeparate) and drive.nameplate is not None
    return drive.nameplate.speed


def _speed(machine: Machine, drive: Drive, motion: Trajectory) -> np.ndarray:
    """The speed of the driven body against the stator."""
    speed = motion_of(machine, motion, machine.body(drive.on))[1]
    turning = dict(zip(machine.labels, machine.carrier, strict=True)).get("r") if drive.stator == "carrier" else None
    if turning is None or turning.prescribed_velocity is not None:
        return speed
    return np.asarray(speed - motion.states[machine.row(turning.velocity)])


def _current_ratio(machine: Machine, drive: Drive, speed: np.ndarray) -> np.ndarray | None:
    """The current of an induction motor over the rated one at speeds (N,); None of others, and where a schedule feeds it."""
    is_scheduled = any(s.parameter.startswith(f"{drive.path}.") for s in machine.schedules)
    if not isinstance(drive, Induction) or drive.nameplate is None or is_scheduled:
        return None
    plate, values = drive.nameplate, machine.values
    synchronous = drive.synchronous_speed()
    rated_current = plate.phase_current or drive.circuit_at(plate.phase_voltage, plate.frequency).current(plate.slip)
    circuit = drive.circuit_at(values[f"{drive.path}.voltage"], values[f"{drive.path}.frequency"])
    if synchronous is None:
        return None
    slips = np.concatenate([-_SLIPS[::-1], _SLIPS])
    currents = np.array([circuit.current(float(s)) for s in slips])
    return np.asarray(np.interp(1 - speed / synchronous, slips, currents) / rated_current)
