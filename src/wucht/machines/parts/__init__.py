"""The parts of a machine: one class a file, each with its formulas. A new part is a new file here, and its name below.

``wucht.parts`` in Python: every class of a part, and of the tables inside parts, is an attribute by its name.

>>> from wucht import parts
>>> parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2").eccentricity
0.001
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, get_args

from wucht.errors import nearest
from wucht.kinds import classes_of, kinds_of
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Load, Part
from wucht.machines.parts.support import Support
from wucht.schema import models_in

if TYPE_CHECKING:  # the names that ``__getattr__`` loads, for type checkers
    from wucht.machines.parts.bearing import Bearing as Bearing
    from wucht.machines.parts.carrier import Carrier as Carrier
    from wucht.machines.parts.carrier import Foundation as Foundation
    from wucht.machines.parts.constant_speed import ConstantSpeed as ConstantSpeed
    from wucht.machines.parts.constant_torque import ConstantTorque as ConstantTorque
    from wucht.machines.parts.coulomb_load import CoulombLoad as CoulombLoad
    from wucht.machines.parts.dc import DC as DC
    from wucht.machines.parts.dc_separate import DCSeparate as DCSeparate
    from wucht.machines.parts.dc_series import DCSeries as DCSeries
    from wucht.machines.parts.dc_shunt import DCShunt as DCShunt
    from wucht.machines.parts.end_stop import EndStop as EndStop
    from wucht.machines.parts.friction_damper import FrictionDamper as FrictionDamper
    from wucht.machines.parts.induction import Induction as Induction
    from wucht.machines.parts.inverter import Inverter as Inverter
    from wucht.machines.parts.linear_drive import LinearDrive as LinearDrive
    from wucht.machines.parts.material_layer import MaterialLayer as MaterialLayer
    from wucht.machines.parts.mounts import EqualMounts as EqualMounts
    from wucht.machines.parts.mounts import Mount as Mount
    from wucht.machines.parts.nameplate import DCNameplate as DCNameplate
    from wucht.machines.parts.nameplate import InductionNameplate as InductionNameplate
    from wucht.machines.parts.oil import Oil as Oil
    from wucht.machines.parts.pendulum import Pendulum as Pendulum
    from wucht.machines.parts.planar_carrier import PlanarCarrier as PlanarCarrier
    from wucht.machines.parts.quadratic_load import QuadraticLoad as QuadraticLoad
    from wucht.machines.parts.release import Release as Release
    from wucht.machines.parts.rocking_carrier import RockingCarrier as RockingCarrier
    from wucht.machines.parts.roller import Roller as Roller
    from wucht.machines.parts.rotor import CentrifugalForce as CentrifugalForce
    from wucht.machines.parts.rotor import Rotor as Rotor
    from wucht.machines.parts.slider import Slider as Slider
    from wucht.machines.parts.support import PrescribedMotion as PrescribedMotion
    from wucht.machines.parts.switchable_pendulum import SwitchablePendulum as SwitchablePendulum
    from wucht.machines.parts.synchronous import Synchronous as Synchronous
    from wucht.machines.parts.table_drive import TableDrive as TableDrive
    from wucht.machines.parts.table_load import TableLoad as TableLoad
    from wucht.machines.parts.transmission import Transmission as Transmission
    from wucht.machines.parts.viscous_load import ViscousLoad as ViscousLoad

GROUP = "wucht.parts"


def part_kinds(family: Any) -> dict[str, type[Any]]:
    """Return all kinds of a family by name, also of the user's packages. Raises ``InputError`` where two have one name."""
    return kinds_of(family, GROUP)


def carriers() -> dict[str, type[Support]]:
    """Return the carriers by the values of ``directions`` that select them in a file: those of the field's Literal."""
    every = part_kinds(Support).values()
    return {name: cls for cls in every for name in get_args(cls.model_fields["directions"].annotation)}


def bodies() -> dict[str, type[Body]]:
    """Return the kinds of bodies by name."""
    return part_kinds(Body)


def drives() -> dict[str, type[Drive]]:
    """Return the kinds of drives by name."""
    return part_kinds(Drive)


def loads() -> dict[str, type[Load]]:
    """Return the kinds of loads by name."""
    return part_kinds(Load)


def attachments() -> dict[str, type[Attachment]]:
    """Return the kinds of attachments by name."""
    return part_kinds(Attachment)


def _classes() -> dict[str, type[Any]]:
    """Parts of every kind, and the tables inside them (``Mount``, ``Release``), by the name of their class."""
    parts = list(classes_of(Part, GROUP))
    tables = [table for cls in parts for field in cls.model_fields.values() for table in models_in(field.annotation)]
    return {cls.__name__: cls for cls in (*tables, *parts)}


def __getattr__(name: str) -> type[Any]:
    if not name[:1].isupper():  # no class; Python requests private names while the package is imported
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    classes = _classes()
    if name not in classes:
        raise AttributeError(f"there is no part {name!r}; {nearest(name, classes)}")
    return classes[name]


def __dir__() -> list[str]:
    return sorted({*_classes(), "attachments", "bodies", "carriers", "drives", "loads", "part_kinds"})
