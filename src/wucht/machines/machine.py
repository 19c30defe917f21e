"""``Machine``: an assembly of parts. From their energies everything else follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from wucht.machines.assembly import assemble_parts, with_tracks
from wucht.machines.attaching import doubts_at_rest
from wucht.machines.mechanism import Mechanism
from wucht.machines.models import DimensionlessMachine
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Load
from wucht.machines.parts.support import Support
from wucht.machines.schedules import Schedule
from wucht.machines.structure import DISSIPATED_WORK, MISMATCH, SUPPLIED_WORK
from wucht.machines.tree import RotatingBody, SlidingBody
from wucht.results.formatting import units_in_print

__all__ = ["DISSIPATED_WORK", "MISMATCH", "SUPPLIED_WORK", "Machine"]


@dataclass(frozen=True, init=False, repr=False)
class Machine(Mechanism):
    """A machine: an assembly of parts, their energies in named coordinates, with parameter values.

    Machines of one structure have equal ``system``s, whatever their values.

    Parameters
    ----------
    carrier
        The support of the bodies, such as ``parts.Carrier``; or a dimensionless machine, such as ``parts.LavalRotor``, alone.
    bodies, drives, loads
        The other parts. Quantities are numbers in SI or strings with a unit. A drive or load acts ``on`` the only rotor by
        default; a body has one drive, and one load of each kind.
    attachments
        Parts fastened to the carrier: dampers, stops, material on it.
    schedules
        Tables ``{"parameter": PATH, "points": [[time, value], ...], "interpolation": "linear" | "steps" | "smooth"}``,
        or the schedules of another machine. ``"smooth"`` is the cubic 3 s^2 - 2 s^3 from value to value, at rest at each point.
    tracks
        Tables ``{"contact_frequency": ...}`` by the name of a track that bodies share.
    title
        The name of the machine in results.

    Attributes
    ----------
    carrier, labels
        The carrier's coordinates, and their names (x, y, r, foundation).
    bodies, sliders
        The bodies that turn, and those in guides, in the order given.
    parameters, values
        Its numbers by path (``p1.damping``): each a ``Parameter`` with value, unit, symbol and name; the values in SI alone.
    frame, energies, mismatch
        The bodies' axes, and gravity; the parts' formulas: the carrier's first, those of contacts last; the power by
        which dampers that are not reciprocal violate action = reaction, or None.
    start_angles, start_positions
        At t = 0, in rad by body and in m (rad) by label, of what has a prescribed motion.
    warnings, notes
        Doubtful input that still runs; the origin of derived parameters, such as a motor's circuit from its nameplate.

    Raises
    ------
    InputError
        Where the parts are inconsistent: the location, the given and the allowed values.

    Examples
    --------
    >>> from wucht import Machine, parts
    >>> drum = parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2")
    >>> ball = parts.Pendulum(name="ball", about="drum", mass="125 g", length="104 mm", damping="0.17 N m s")
    >>> motor = parts.LinearDrive(slope="0.04 N m s", no_load_speed="200 rad/s")
    >>> Machine(parts.Carrier(mass="1 kg", stiffness="1e5 N/m"), [drum, ball], [motor], title="A drum")
    <Machine 'A drum'
     rotor drum, pendulum ball; drive linear on drum; 13 parameters>
    """

    def __init__(
        self,
        carrier: Support | DimensionlessMachine,
        bodies: Sequence[Body] = (),
        drives: Sequence[Drive] = (),
        loads: Sequence[Load] = (),
        *,
        attachments: Sequence[Attachment] = (),
        schedules: Sequence[Mapping[str, Any] | Schedule] = (),
        tracks: Mapping[str, Mapping[str, Any]] | None = None,
        title: str = "",
    ) -> None:
        track_tables = {} if tracks is None else tracks
        # A frozen class sets its fields past its lock.
        self.__dict__.update(assemble_parts(carrier, bodies, drives, loads, attachments, schedules, track_tables, title))
        self.__dict__.update(vars(with_tracks(self.with_fields().at(0.0), track_tables)))
        self.__dict__["warnings"] = (*self.warnings, *doubts_at_rest(self))

    @property
    def _all_bodies(self) -> tuple[RotatingBody | SlidingBody, ...]:
        return (*self.bodies, *(x for x in self.sliders if x.name != x.about))

    def __repr__(self) -> str:
        driven = [f"{d.kind} on {d.on}" for d in self.drives]
        drives = f"{'drive' if len(driven) == 1 else 'drives'} {', '.join(driven)}; " if driven else ""
        bodies = ", ".join(_body_label(b) for b in self._all_bodies)
        return f"<Machine {self.title!r}\n {bodies}; {drives}{len(self.parameters)} parameters>"

    def _repr_html_(self) -> str:
        rows = [(_body_label(b), "", f"on {b.about or 'the carrier'}") for b in self._all_bodies]
        rows += [(f"{d.kind} drive", "", f"on {d.on}") for d in self.drives]
        rows += [(path, f"{p.value:.6g} {units_in_print(p.unit)}".rstrip(), p.long_name) for path, p in self.parameters.items()]
        cells = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
        return f"<table><caption>{escape(self.title)}</caption>{cells}</table>"


def _body_label(body: RotatingBody | SlidingBody) -> str:
    return f"{body.kind} {body.name}" if body.kind != body.name else body.name
