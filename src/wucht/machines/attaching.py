"""What is fastened to the carrier: whether its place moves, and where that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from wucht.errors import InputError
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Point
from wucht.machines.parts.support import Support

_ACROSS = 1e-9  # cosine of the angle between a line and a motion that are across to each other


def check_attachments(attachments: Sequence[Attachment], carrier: Support, taken: Sequence[str]) -> None:
    """Each has a name of its own, and is where the carrier moves. taken: other names. Raises ``InputError``."""
    for i, attached in enumerate(attachments):
        if attached.name in (*taken, *(a.name for a in attachments[:i])):
            sentence = "this name is taken; each body and attachment needs its own"
            raise InputError(f"attachments[{i}].name", attached.name, sentence)
        if attached.at is not None and carrier.placed().rotation == 0:
            sentence = f"allowed on a carrier that turns in its plane; this one is {carrier.directions!r}"
            raise InputError(f"{attached.path}.at", list(attached.at), sentence)
        velocities = attached.motion(replace(carrier.placed(), axes={attached.name: place_of(attached, carrier)}))
        moved = [sp.diff(v, c.velocity) for v in velocities for c in carrier.coordinates()]
        if not any(abs(attached.number(x)) > _ACROSS for x in moved):
            sentence = f"a carrier {carrier.directions!r} does not move in the direction in which this part acts"
            raise InputError(f"attachments[{i}]", attached.name, sentence)


def place_of(attached: Attachment, carrier: Support) -> Point:
    """Where it is on the carrier."""
    return carrier.axis_at(attached.place() or (sp.S.Zero, sp.S.Zero))
