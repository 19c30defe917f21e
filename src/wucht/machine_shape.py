"""The shape of a machine from the values of its parameters: carrier, springs, rotors, tracks and bodies.

It serves the figure of a report, where values are numbers, and the moving drawing, where they are expressions in parameters.
Places, tracks, arms and radii of bodies are to scale. Sizes of rotors and carrier are no data of a machine: they are drawn
around what they have on them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

_MARGIN = 1.18  # of a rotor around its outermost body
_ROTOR, _NEAREST = (
    0.2,
    0.44,
)  # the radius of a rotor without bodies, over the extent of all places and the next rotor's distance
_CARRIER, _CARRIER_ON_MOUNTS = 1.3, 1.12  # around its rotors
_ARM_KEYS = ("length", "outer_stop", "radius")  # radii at which bodies without a track are, the first that there is
_NO_LENGTH = 0.72  # of the rotor's radius: where bodies are whose arms have no lengths
_SHRINK = 0.7  # of a rotor at the place of another one

Length = Any  # in m: a number, or an expression in the parameters


@dataclass(frozen=True)
class Arithmetic:
    """Operations on lengths. number: the value of a length, on which the choice between two shapes depends."""

    largest: Callable[[Sequence[Length]], Length]
    smallest: Callable[[Sequence[Length]], Length]
    root: Callable[[Length], Length]
    number: Callable[[Length], float]

    def distance(self, x: Length, y: Length) -> Length:
        """Return the distance of a point from the origin."""
        return self.root(x * x + y * y)


NUMBERS = Arithmetic(max, min, math.sqrt, float)


@dataclass(frozen=True)
class BodyShape:
    """A body that turns about a rotor, or slides in a guide of it.

    arm: from its axis, or its pivot, to its centre. size: its radius, 0 for a point. track: radius of the track on which it
    rolls, 0 without one. reach: from the rotor's axis to its centre, at most.
    """

    name: str
    kind: str
    arm: Length
    size: Length
    track: Length
    reach: Length


@dataclass(frozen=True)
class RotorShape:
    """A rotor: its axis and radius, its bodies, and the sense in which its drive turns it, 0 without one."""

    name: str
    x: Length
    y: Length
    radius: Length
    sense: int
    bodies: tuple[BodyShape, ...]


@dataclass(frozen=True)
class MountShape:
    """A spring with a damper between the carrier and the ground: its place, and the direction away from the carrier."""

    x: Length
    y: Length
    dx: float
    dy: float
    has_damper: bool
    name: str = ""


@dataclass(frozen=True)
class AttachmentShape:
    """A part fastened to the carrier: its place on a carrier that turns, None at the centre of another one."""

    name: str
    kind: str
    x: Length | None
    y: Length | None


@dataclass(frozen=True)
class MachineShape:
    """The shapes of a machine. box: left, bottom, right, top of the carrier. to_scale: whether lengths are known."""

    rotors: tuple[RotorShape, ...]
    mounts: tuple[MountShape, ...]
    box: tuple[Length, Length, Length, Length]
    to_scale: bool
    pivot: bool = False
    is_fixed: bool = False
    is_shaken: bool = False
    foundation: bool = False
    attachments: tuple[AttachmentShape, ...] = ()

    @property
    def size(self) -> float:
        """The larger side of the carrier, where lengths are numbers."""
        return float(max(self.box[2] - self.box[0], self.box[3] - self.box[1]))


def machine_shape(
    bodies: Sequence[Sequence[Any]],
    values: Mapping[str, Length],
    parts: Sequence[Mapping[str, Any]],
    *,
    dimensionless: bool,
    arithmetic: Arithmetic = NUMBERS,
) -> MachineShape:
    """Return the shape of a machine.

    Parameters
    ----------
    bodies : sequence
        Name, kind and the body that it turns about (None: on the carrier) of each body that turns.
    values : mapping
        Values of the parameters by path: numbers in SI, or expressions.
    parts : sequence of mappings
        ``path``, ``kind``, and the body ``on`` which it acts or about which it turns; of the carrier its ``directions``, of
        drives their ``sense``.
    dimensionless : bool
        Whether the machine has no lengths.
    arithmetic : Arithmetic
        Operations on the values.

    Returns
    -------
    MachineShape
        Lengths in m, or as expressions.
    """
    by_path = {part["path"]: part for part in parts}
    rotors = _rotors(bodies, values, parts, arithmetic)
    carrier = by_path.get("carrier") or by_path.get("") or {}
    directions = [d for d in carrier.get("directions", ()) if d != "foundation"]
    attachments = tuple(
        AttachmentShape(path, part["kind"], values.get(f"{path}.at.x"), values.get(f"{path}.at.y"))
        for path, part in by_path.items()
        if path not in ("", "carrier", *(body[0] for body in bodies))
        and part["kind"] not in ("track", "slider") and not path.startswith(("drive", "load"))
    )  # fmt: skip
    places = _mount_places(values)
    box = _carrier_box(rotors, [*places, *((a.x, a.y) for a in attachments if a.x is not None)], bool(places), arithmetic)
    mounts = (
        _mounts_at(places, box, values, arithmetic)
        if places
        else _springs(directions, box, values, arithmetic, dimensionless=dimensionless)
    )
    has_lengths = any(arithmetic.number(body.arm) for rotor in rotors for body in rotor.bodies)
    return MachineShape(
        rotors, mounts, box,
        to_scale=(has_lengths and not dimensionless) or bool(places) or _are_apart(rotors, arithmetic),
        pivot=directions == ["r"], is_fixed=not directions,
        is_shaken=any(path.startswith("carrier.motion.") for path in values),
        foundation=any(path.startswith("carrier.foundation.") for path in values), attachments=attachments,
    )  # fmt: skip


def _rotors(
    bodies: Sequence[Sequence[Any]], values: Mapping[str, Length], parts: Sequence[Mapping[str, Any]], arithmetic: Arithmetic
) -> tuple[RotorShape, ...]:
    """Return the rotors on the carrier, with all bodies that turn about them, directly or through others, or slide in them."""
    sliding = [(part["path"], part["kind"], part["on"]) for part in parts if part["kind"] == "slider"]
    about = {name: on for name, _, on in (*bodies, *sliding)}
    senses = {p["on"]: _sense(p, values, arithmetic) for p in parts if "sense" in p}

    def root(name: str) -> str:
        for _ in about:
            name = about.get(name) or name
        return name

    roots = [(name, _place(name, values)) for name, _, on in bodies if not on]
    bare_radius = _bare_radius([place for _, place in roots], _mount_places(values), arithmetic)
    shapes = []
    for name, (x, y) in roots:
        on_it = [_body_shape(b, kind, values, arithmetic) for b, kind, on in (*bodies, *sliding) if on and root(b) == name]
        outermost = arithmetic.largest([size for b in on_it for size in (b.reach + b.size, b.track)] or [0.0])
        has_size = arithmetic.number(outermost) > 0
        radius = _MARGIN * outermost if has_size else bare_radius
        if not has_size:  # as of a dimensionless machine: the arms have no lengths
            arm = _NO_LENGTH * radius
            on_it = [replace(b, arm=arm, reach=arm) for b in on_it]
        shapes.append(RotorShape(name, x, y, radius, senses.get(name, 0), tuple(on_it)))
    return _apart(shapes, arithmetic)


def _bare_radius(
    places: Sequence[tuple[Length, Length]], mounts: Sequence[tuple[Length, Length]], arithmetic: Arithmetic
) -> Length:
    """Return the radius of a rotor without bodies; 1 where no places give a size."""
    distances = [arithmetic.distance(a[0] - b[0], a[1] - b[1]) for k, a in enumerate(places) for b in places[:k]]
    distances = [d for d in distances if arithmetic.number(d) > 0]
    extents = [*distances, *(2 * arithmetic.distance(x, y) for x, y in mounts)]
    if not any(arithmetic.number(extent) for extent in extents):
        return 1.0
    return arithmetic.smallest([_ROTOR * arithmetic.largest(extents), *(_NEAREST * d for d in distances)])


def _apart(rotors: Sequence[RotorShape], arithmetic: Arithmetic) -> tuple[RotorShape, ...]:
    """Return the rotors; of those at one place each that follows is drawn smaller."""
    shapes, count = [], dict[tuple[float, float], int]()
    for r in rotors:
        place = arithmetic.number(r.x), arithmetic.number(r.y)
        k = count[place] = count.get(place, -1) + 1
        shapes.append(replace(r, radius=r.radius * _SHRINK**k) if k and not r.bodies else r)
    return tuple(shapes)


def _are_apart(rotors: Sequence[RotorShape], arithmetic: Arithmetic) -> bool:
    return len({(arithmetic.number(r.x), arithmetic.number(r.y)) for r in rotors}) > 1


def _sense(drive: Mapping[str, Any], values: Mapping[str, Length], arithmetic: Arithmetic) -> int:
    """Return the sense of a drive: as stated, or by the sign of the speed that it has without a load."""
    speeds = (values.get(f"{drive['path']}.{key}", 0.0) for key in ("no_load_speed", "speed", "set_speed", "voltage"))
    return int(drive["sense"]) * (-1 if next((v for v in map(arithmetic.number, speeds) if v), 1.0) < 0 else 1)


def _place(name: str, values: Mapping[str, Length]) -> tuple[Length, Length]:
    return values.get(f"{name}.position.x", 0.0), values.get(f"{name}.position.y", 0.0)


def _body_shape(name: str, kind: str, values: Mapping[str, Length], arithmetic: Arithmetic) -> BodyShape:
    if f"{name}.track_radius" in values:
        track, radius = values[f"{name}.track_radius"], values.get(f"{name}.radius", 0.0)
        return BodyShape(name, kind, track - radius, radius, track, track - radius)
    arm = next((values[f"{name}.{key}"] for key in _ARM_KEYS if f"{name}.{key}" in values), 0.0)
    pivot = [values[f"{name}.suspension.{d}"] for d in "xy" if f"{name}.suspension.{d}" in values]
    reach = arm + arithmetic.distance(*pivot) if pivot else arm
    return BodyShape(name, kind, arm, values.get(f"{name}.diameter", 0.0) / 2, 0.0, reach)


def _mount_places(values: Mapping[str, Length]) -> list[tuple[Length, Length]]:
    places, k = [], 1
    while f"carrier.mounts.{k}.at.x" in values:
        places.append((values[f"carrier.mounts.{k}.at.x"], values[f"carrier.mounts.{k}.at.y"]))
        k += 1
    return places


def _carrier_box(
    rotors: Sequence[RotorShape], places: Sequence[tuple[Length, Length]], on_mounts: bool, arithmetic: Arithmetic
) -> tuple[Length, Length, Length, Length]:
    """Return the rectangle of the carrier: around its rotors, as wide as its mounts are apart."""
    pad = _CARRIER_ON_MOUNTS if on_mounts else _CARRIER
    xs, ys = [x for x, _ in places], [y for _, y in places]
    left = arithmetic.smallest([*(r.x - pad * r.radius for r in rotors), *xs])
    right = arithmetic.largest([*(r.x + pad * r.radius for r in rotors), *xs])
    bottom = arithmetic.smallest([*(r.y - pad * r.radius for r in rotors), *ys])
    top = arithmetic.largest([*(r.y + pad * r.radius for r in rotors), *ys])
    rim = 0.09 * arithmetic.largest([right - left, top - bottom]) if on_mounts else 0.0
    return left - rim, bottom, right + rim, top + rim / 2


def _mounts_at(
    places: Sequence[tuple[Length, Length]],
    box: tuple[Length, Length, Length, Length],
    values: Mapping[str, Length],
    arithmetic: Arithmetic,
) -> tuple[MountShape, ...]:
    """Return mounts at their places, each down to the ground, or up where it is in the upper half of the carrier."""
    bottom, top = arithmetic.number(box[1]), arithmetic.number(box[3])
    heights = [arithmetic.number(y) for _, y in places]
    upward = [y > (bottom + top) / 2 and y >= 0.98 * top for y in heights]
    return tuple(
        MountShape(x, y, 0.0, 1.0 if up else -1.0, _is_damped(f"carrier.mounts.{k}.", values, arithmetic), str(k))
        for k, ((x, y), up) in enumerate(zip(places, upward, strict=True), 1)
    )


def _is_damped(prefix: str, values: Mapping[str, Length], arithmetic: Arithmetic) -> bool:
    return any(arithmetic.number(values.get(f"{prefix}damping{end}", 0.0)) > 0 for end in ("", ".x", ".y"))


def _springs(
    directions: Sequence[str],
    box: tuple[Length, Length, Length, Length],
    values: Mapping[str, Length],
    arithmetic: Arithmetic,
    *,
    dimensionless: bool,
) -> tuple[MountShape, ...]:
    """Return the springs of a carrier without mounts: one for each direction in which it translates."""
    has_damper = dimensionless or _is_damped("carrier.", values, arithmetic)
    x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    shapes = {"x": MountShape(box[0], y, -1.0, 0.0, has_damper), "y": MountShape(x, box[1], 0.0, -1.0, has_damper)}
    return tuple(shapes[d] for d in directions if d in shapes)
