"""The table [shaft] of a cam file: inertia, drive, loads and stiffness of the camshaft."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
import sympy as sp
from pydantic import BeforeValidator, Field, model_validator

from wucht.analysis.working_points import Curve, curves, dry_friction
from wucht.cams.elastic_output import ElasticOutput
from wucht.cams.elastic_shaft import ElasticShaft
from wucht.cams.prediction import CamShaft
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.tables import with_tables
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, shaft_torques
from wucht.machines.parts import drives, loads
from wucht.machines.parts.base import ShaftPart
from wucht.schema import SI, Composite, TableModel, Unit, composite, fields_of, read_quantity, refuse_unknown, si

_STIFFNESS = {"rad": Unit("N m/rad", "rotational stiffness"), "m": Unit("N/m", "stiffness")}
_DAMPING = {"rad": Unit("N m s/rad", "rotational damping"), "m": Unit("N s/m", "damping")}
_MOVES = {"rad": "turns", "m": "slides"}
_DAMPING_RATIO = 0.02  # as of [law.resonance]
_ON = "camshaft"  # the rotor of the machine by which drive and loads are read
_FULL_FRICTION = 4.0  # times the speed of its transition: there dry friction is at 99.9 % of its torque
_FAST = 1e3  # rad/s: no camshaft is expected to be faster
_SPEED_SAMPLES, _SPEED_RANGE = 400, 10.0  # speeds, and times the expected one, up to which a drive is checked to carry its load


def _check_quantity(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError("must be a number, or a string with a unit")
    return value


_OutputQuantity = Annotated[
    float | str, BeforeValidator(_check_quantity)
]  # its unit depends on whether the output turns or slides


@dataclass(frozen=True, eq=False)
class CamshaftDrive:
    """Torques on a camshaft. torques: of the drive, and of all loads against it. speed: that the drive reaches with an output
    that rests, in rad/s. is_enforced: the drive holds this speed at any torque. friction: of dry loads, N m, and
    transition: the speed of their smooth transition at standstill, rad/s. inertia: of a motor behind a gear, reduced to the
    shaft, kg m^2."""

    torques: Curve
    speed: float
    is_enforced: bool
    friction: float = 0.0
    transition: float = 0.0
    inertia: float = 0.0

    def net(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ``prediction.Torque``."""
        (drive, load), (drive_slope, load_slope) = self.torques(speeds)
        return drive - load, drive_slope - load_slope

    def stall_reason(self, speed: float) -> str:
        """Return why a shaft with a computed speed in rad/s does not turn in reality; empty where it turns.

        Smoothed dry friction gives way to any torque, slowly, within its transition; real dry friction holds.
        """
        starting = float(self.torques(np.array([0.0]))[0][0, 0])
        if not self.friction or speed >= _FULL_FRICTION * self.transition or starting > self.friction:
            return ""
        explanation = (
            f"the drive's torque of {starting:.4g} N m at standstill does not overcome the load of {self.friction:.4g} N m"
        )
        return f"{explanation}: the shaft stands still; give a stronger drive or a smaller load"

    def no_speed_reason(self, expected_speed: float) -> str:
        """Return why no speed is possible up to ten times the expected one in rad/s; empty where one is."""
        if not (stall := self.stall_reason(0.0)):
            return ""
        speeds = np.geomspace(_FULL_FRICTION * self.transition, _SPEED_RANGE * expected_speed, _SPEED_SAMPLES)
        return "" if (self.net(speeds)[0] > 0).any() else stall


class ElasticTable(TableModel):
    """Springs that the rigid prediction leaves out."""

    output_frequency: SI[float | None] = si("rad/s", "natural frequency of the output", default=None, gt=0, help=(
        "natural frequency of the output on the spring between it and the cam's lever, the lever held; or `output_stiffness`"
    ))  # fmt: skip
    output_stiffness: _OutputQuantity | None = Field(default=None, title="stiffness between lever and output", description=(
        "stiffness between lever and output, in N m/rad or N/m, instead of `output_frequency`"
    ))  # fmt: skip
    output_damping_ratio: SI[float | None] = si("", "damping ratio of the output", default=None, ge=0, lt=1, help=(
        "damping ratio of the output, by default 0.02; or `output_damping`"
    ))  # fmt: skip
    output_damping: _OutputQuantity | None = Field(default=None, title="damping between lever and output", description=(
        "damping between lever and output, in N m s/rad or N s/m, instead of `output_damping_ratio`"
    ))  # fmt: skip
    shaft_stiffness: SI[float | None] = si("N m/rad", "stiffness of the camshaft", default=None, gt=0, help=(
        "stiffness of the camshaft between the flywheel and the cam"
    ))  # fmt: skip
    shaft_damping: SI[float] = si("N m s/rad", "damping of the camshaft", default=0.0, ge=0, help=(
        "damping of the camshaft between the flywheel and the cam"
    ))  # fmt: skip
    cam_inertia: SI[float | None] = si("kg m^2", "moment of inertia of the cam", default=None, gt=0, help=(
        "moment of inertia of the cam alone, a part of `shaft.inertia`, where the camshaft is elastic"
    ))  # fmt: skip

    @classmethod
    def error_location(cls) -> str:
        """Return its path in a file."""
        return "shaft.elastic"

    @model_validator(mode="after")
    def _check_combinations(self) -> Self:
        if self.output_frequency is not None and self.output_stiffness is not None:
            raise ValueError("output_stiffness", "give either output_frequency or output_stiffness")
        if self.output_damping_ratio is not None and self.output_damping is not None:
            raise ValueError("output_damping", "give either output_damping_ratio or output_damping")
        if (self.shaft_stiffness is None) != (self.cam_inertia is None):
            missing = "cam_inertia" if self.cam_inertia is None else "shaft_stiffness"
            raise ValueError(missing, "an elastic camshaft needs shaft_stiffness and cam_inertia")
        if self.output_frequency is None and self.output_stiffness is None and self.shaft_stiffness is None:
            raise ValueError("output_frequency", "give output_frequency or output_stiffness, or shaft_stiffness")
        return self

    def output(self, inertia: float, unit: str) -> ElasticOutput | None:
        """Return the output on its spring, None where it is rigid. inertia: of the output. unit: of its motion, rad or m."""
        if self.output_frequency is None and self.output_stiffness is None:
            return None
        if inertia <= 0:
            raise InputError("shaft.elastic", None, "an elastic output must have an inertia above zero")
        stiffness = inertia * (self.output_frequency or 0.0) ** 2
        if self.output_stiffness is not None:
            location = "shaft.elastic.output_stiffness"
            stiffness = _read_output_quantity(_STIFFNESS[unit], self.output_stiffness, location, unit)
            if stiffness <= 0:
                raise InputError(location, self.output_stiffness, "must be above zero")
        if self.output_damping is None:
            ratio = _DAMPING_RATIO if self.output_damping_ratio is None else self.output_damping_ratio
            return ElasticOutput(inertia, stiffness, 2 * ratio * float(np.sqrt(stiffness * inertia)))
        location = "shaft.elastic.output_damping"
        damping = _read_output_quantity(_DAMPING[unit], self.output_damping, location, unit)
        if damping < 0:
            raise InputError(location, self.output_damping, "must not be negative")
        return ElasticOutput(inertia, stiffness, damping)


def _read_output_quantity(quantity: Unit, value: float | str, location: str, unit: str) -> float:
    """Return the quantity in SI. Raises ``InputError``, naming the motion of the output, which decides the unit."""
    try:
        return read_quantity(quantity, value, location)
    except InputError as error:
        raise InputError(location, value, f"{error.explanation}; the output {_MOVES[unit]}, its law is in {unit}") from None


class ShaftTable(TableModel):
    """The camshaft with what drives and loads it, from which its speed is predicted."""

    inertia: SI[float] = si("kg m^2", "moment of inertia", gt=0, help="moment of inertia of what turns with the cam")
    output_inertia: SI[float | None] = si("kg m^2", "moment of inertia of the output", default=None, ge=0, help=(
        "moment of inertia of what moves with the output, where that turns"
    ))  # fmt: skip
    output_mass: SI[float | None] = si("kg", "mass of the output", default=None, ge=0, help="mass of an output that slides")
    mean_speed: SI[float | None] = si("rad/s", "mean speed", default=None, gt=0, help=(
        "mean speed of the eigenmotion, without a drive; the expected mean speed, with a drive"
    ))  # fmt: skip
    drive: Composite[dict[str, Any] | None] = composite(
        default=None,
        title="drive, a table: [shaft.drive]",
        description="drive with the keys of a machine's, except `on`, a table: `[shaft.drive]`",
    )
    loads: Composite[tuple[dict[str, Any], ...]] = composite(
        default=(),
        title="loads, tables: [[shaft.loads]]",
        description="loads with the keys of a machine's, except `on`, tables: `[[shaft.loads]]`",
    )
    elastic: Composite[ElasticTable | None] = composite(default=None, title="springs, a table: [shaft.elastic]", description=(
        "springs that the rigid prediction leaves out, a table: `[shaft.elastic]`"
    ))  # fmt: skip

    @classmethod
    def error_location(cls) -> str:
        """Return its path in a file."""
        return "shaft"

    @model_validator(mode="after")
    def _check_combinations(self) -> Self:
        if self.output_inertia is None and self.output_mass is None:
            raise ValueError(
                "output_inertia", "give the output_inertia of an output that turns, or the output_mass of one that slides"
            )
        if self.output_inertia is not None and self.output_mass is not None:
            raise ValueError("output_mass", "give only one: output_inertia of an output that turns, output_mass if it slides")
        cam = self.elastic.cam_inertia if self.elastic is not None else None
        if cam is not None and cam >= self.inertia:
            raise ValueError("inertia", f"must be above elastic.cam_inertia = {cam:g} kg m^2, which is a part of it")
        return self

    def camshaft_drive(self, folder: Path) -> CamshaftDrive | None:
        """Return the torques on the shaft, None where there are none: the eigenmotion. folder: the folder of files of tables.

        Raises ``InputError``, located from ``shaft`` on.
        """
        if self.drive is None:
            if self.loads:
                raise InputError("shaft.loads", None, "nothing drives the shaft against its loads: give [shaft.drive] too")
            if self.mean_speed is None:
                raise InputError("shaft.mean_speed", None, "give the mean speed of the eigenmotion, or [shaft.drive]")
            return None
        machine = self._machine(folder)
        if machine.internal:
            kind, instead = self.drive.get("kind"), "'linear' with its gain as slope, or 'constant-speed'"
            sentence = f"not allowed on a camshaft: a controller's torque does not follow from the speed alone; take {instead}"
            raise InputError("shaft.drive.kind", kind, sentence)
        is_enforced = machine.rotor.coordinate.prescribed_velocity is not None
        if is_enforced and self.mean_speed is not None:
            raise InputError("shaft.mean_speed", self.mean_speed, "not allowed beside a drive that enforces a speed")
        final_speed = self.mean_speed if self.mean_speed is not None else free_speed(machine, machine.rotor)
        if final_speed is None:
            requirement = "nothing limits the speed that this drive reaches: give [[shaft.loads]], or the expected mean_speed"
            raise InputError("shaft.drive", self.drive.get("kind"), requirement, code="no-limit")
        if not final_speed > 0:
            requirement = (
                f"it would turn the shaft at {final_speed:.4g} rad/s: this speed must be above zero, as the cam "
                "angle counts in the sense of the shaft"
            )
            raise InputError("shaft.drive", self.drive.get("kind"), requirement, code="turns-back")
        (inertia,) = machine.evaluate(sp.Add(*(d.reduced_inertia() for d in machine.drives)))
        torques = curves(machine, shaft_torques(machine, machine.rotor))
        driving = CamshaftDrive(torques, final_speed, is_enforced, *dry_friction(machine), float(inertia))
        if not is_enforced and self.mean_speed is not None and (stall := driving.no_speed_reason(final_speed)):
            raise InputError("shaft.drive", self.drive.get("kind"), stall, code="stands")
        if not is_enforced and self.mean_speed is None and (stall := driving.stall_reason(final_speed)):
            hint = "" if driving.no_speed_reason(_FAST) else ", or, if something else starts the shaft, the expected mean_speed"
            raise InputError("shaft.drive", self.drive.get("kind"), f"{stall}{hint}", code="stands")
        return driving

    def _machine(self, folder: Path) -> Machine:
        """Return a rotor alone with the drive and the loads. Raises ``InputError``, located from ``shaft`` on."""
        _check_keys(self.drive or {}, drives(), "shaft.drive")
        for i, load in enumerate(self.loads):
            _check_keys(load, loads(), f"shaft.loads[{i}]")
        rotor = {"kind": "rotor", "name": _ON, "mass": 1.0, "eccentricity": 0.0, "inertia": self.inertia}
        document = {"carrier": {"directions": "fixed"}, "bodies": [rotor], "drive": self.drive, "loads": list(self.loads)}
        try:
            return machine_from(with_tables(document, folder))
        except InputError as error:
            location = error.location.replace("machine.", "shaft.", 1)
            raise InputError(location, error.value, error.explanation.replace("machine.", "shaft.")) from None

    def camshaft(self, driving: CamshaftDrive | None, unit: str) -> CamShaft:
        """Return the shaft with an output that moves in rad or m. Raises ``InputError`` where its inertia has another unit."""
        torque = None if driving is None or driving.is_enforced else driving.net
        speed = driving.speed if driving is not None else self.mean_speed or 0.0
        turning = self.inertia + (0.0 if driving is None else driving.inertia)
        return CamShaft(turning, self.moving_inertia(unit), speed, torque)

    def moving_inertia(self, unit: str) -> float:
        """Return the inertia of an output that turns (rad) or slides (m). Raises ``InputError``."""
        options: Mapping[str, tuple[str, float | None]] = {
            "rad": ("output_inertia", self.output_inertia),
            "m": ("output_mass", self.output_mass),
        }
        key, value = options[unit]
        if value is None:
            wrong_key = "output_mass" if unit == "rad" else "output_inertia"
            raise InputError(
                f"shaft.{wrong_key}", None, f"the output {_MOVES[unit]} (its law is in {unit}): give {key} instead"
            )
        return value

    def twisting(self) -> ElasticShaft | None:
        """Return the camshaft on its spring, None where it is rigid."""
        e = self.elastic
        if e is None or e.shaft_stiffness is None or e.cam_inertia is None:
            return None
        return ElasticShaft(e.cam_inertia, e.shaft_stiffness, e.shaft_damping)


def _check_keys(entries: Mapping[str, Any], kinds: Mapping[str, type[ShaftPart]], location: str) -> None:
    """Raise ``InputError`` for a key that a drive or a load of this kind does not have on a camshaft."""
    if "on" in entries:
        raise InputError(f"{location}.on", entries["on"], "unknown key: all drives and loads act on the camshaft here")
    kind = entries.get("kind")
    if isinstance(kind, str) and kind in kinds:
        file_key = {"file"} if kind == "table" else set()  # read before the part is built, which has the points
        keys = {k: v for k, v in entries.items() if k != "kind"}
        refuse_unknown(keys, {*fields_of(kinds[kind], settable_only=True), *file_key} - {"on"}, location)
