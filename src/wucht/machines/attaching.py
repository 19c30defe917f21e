"""Attachments of the carrier: checks that their place moves, their position, and their state at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from wucht.errors import InputError
from wucht.machines.mechanism import Mechanism
from wucht.machines.parts.attachment import Attachment, LineAttachment
from wucht.machines.parts.base import Point
from wucht.machines.parts.support import Support

_ACROSS = 1e-9  # cosine of the angle between a line and a motion that are across to each other


def check_attachments(attachments: Sequence[Attachment], carrier: Support, used_names: Sequence[str]) -> None:
    """Check that each has a unique name, and is where the carrier moves. used_names: of other parts. Raises ``InputError``."""
    for i, attachment in enumerate(attachments):
        if attachment.name in (*used_names, *(a.name for a in attachments[:i])):
            sentence = "this name is already used; the names of bodies and attachments must differ"
            raise InputError(f"attachments[{i}].name", attachment.name, sentence)
        turns = carrier.reference_frame().rotation != 0
        if attachment.at is not None and not turns:
            sentence = f"allowed only on a carrier that turns in its plane, which this one, {carrier.directions!r}, does not"
            raise InputError(f"{attachment.path}.at", list(attachment.at), sentence)
        velocities = attachment.motion(
            replace(carrier.reference_frame(), axes={attachment.name: place_of(attachment, carrier)})
        )
        sensitivities = [sp.diff(v, c.velocity) for v in velocities for c in carrier.coordinates()]
        if not any(abs(attachment.number(x)) > _ACROSS for x in sensitivities):
            hint = "; give its place, at = [x, y]" if turns and attachment.at is None else ""
            sentence = f"a carrier {carrier.directions!r} does not move in the direction in which this part acts{hint}"
            raise InputError(f"attachments[{i}]", attachment.name, sentence)


def doubts_at_rest(machine: Mechanism) -> tuple[str, ...]:
    """Return warnings about parts that are already pressed where the carrier rests."""
    lines = [part for part in machine.parts if isinstance(part, LineAttachment)]
    if not lines:
        return ()
    at = machine.numbers | {c.position: x for c, x in zip(machine.carrier, machine.rest, strict=True)}
    along = [float(sp.sympify(part.line_motion(machine.frame)[0]).xreplace(at)) for part in lines]
    return tuple(doubt for part, s in zip(lines, along, strict=True) for doubt in part.doubts_at(s))


def place_of(attachment: Attachment, carrier: Support) -> Point:
    """Return its position on the carrier."""
    return carrier.axis_at(attachment.place() or (sp.S.Zero, sp.S.Zero))
