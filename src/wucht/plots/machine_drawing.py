"""A machine drawn from the numbers of its result: carrier on springs, rotors with their unbalance, tracks and bodies.

Places, tracks, arms and radii of bodies are to scale. Sizes of rotors and carrier are no data of a machine: they are drawn
around what they have on them. Bodies of a rotor are spread evenly, whatever their angles at the start are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wucht.plots.page import REPORT, page_context
from wucht.plots.style import COLOURS, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from wucht.results.accessor import ResultAccessor

_MARGIN = 1.18  # of a rotor around its outermost body
_ROTOR, _NEAREST = (
    0.2,
    0.44,
)  # the radius of a rotor without bodies, over the extent of all places and the next rotor's distance
_CARRIER = 1.3  # around its rotor
_LARGEST_HEIGHT, _INCHES = 3.3, 6.2  # of the drawing
_ARM_KEYS = ("length", "outer_stop", "radius")  # radii at which bodies without a track are, the first that there is
_FIRST_BODY = math.radians(60)  # the angle of the first body of a rotor: neither the unbalance nor the name is there
_BACKGROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}  # of names
_AT_CENTRE: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": REPORT.small}
_LINE: dict[str, Any] = {"color": "black", "linewidth": 0.9, "solid_capstyle": "round"}


@dataclass(frozen=True)
class BodyShape:
    """A body that turns about a rotor, in m. arm: from the axis to its centre. size: its radius, 0 for a point.

    track: radius of the track on which it rolls, 0 without one."""

    name: str
    kind: str
    arm: float
    size: float
    track: float


@dataclass(frozen=True)
class RotorShape:
    """A rotor: its axis and radius in m, its bodies, and the sense in which its drive turns it, 0 without one."""

    name: str
    x: float
    y: float
    radius: float
    sense: int
    bodies: tuple[BodyShape, ...]


@dataclass(frozen=True)
class MountShape:
    """A spring with a damper between the carrier and the ground: its place in m, and the direction away from the carrier."""

    x: float
    y: float
    dx: float
    dy: float
    has_damper: bool
    name: str = ""


@dataclass(frozen=True)
class MachineShape:
    """What is drawn of a machine. box: left, bottom, right, top of the carrier in m. to_scale: whether lengths are known."""

    rotors: tuple[RotorShape, ...]
    mounts: tuple[MountShape, ...]
    box: tuple[float, float, float, float]
    to_scale: bool
    pivot: bool = False
    is_fixed: bool = False
    is_shaken: bool = False
    foundation: bool = False
    attachments: tuple[tuple[str, float | None, float | None], ...] = ()

    @property
    def size(self) -> float:
        """The larger side of the carrier."""
        return max(self.box[2] - self.box[0], self.box[3] - self.box[1])


def machine_shape(result: ResultAccessor) -> MachineShape | None:
    """The shape of the machine of a result, None for a result of another subject, or of a version that recorded no parts."""
    bodies = result.machine.get("bodies")
    if not bodies or not result.parts:
        return None
    values = {path: value for path, value in result.machine["parameters"].items() if isinstance(value, int | float)}
    parts = {part["path"]: part for part in result.parts}
    rotors = _rotors(bodies, values, result.parts)
    carrier = parts.get("carrier") or parts.get("") or {}
    directions = [d for d in carrier.get("directions", ()) if d != "foundation"]
    attachments = tuple(
        (f"{path} ({part['kind']})", values.get(f"{path}.at.x"), values.get(f"{path}.at.y"))
        for path, part in parts.items()
        if path not in ("", "carrier", *(body[0] for body in bodies))
        and part["kind"] != "track" and not path.startswith(("drive", "load"))
    )  # fmt: skip
    places = _mount_places(values)
    box = _carrier_box(rotors, places, [(x, y) for _, x, y in attachments if x is not None and y is not None])
    mounts = (
        _mounts_at(places, box, values) if places else _springs(directions, box, values, dimensionless=result.dimensionless)
    )
    is_shaken = any(path.startswith("carrier.motion.") for path in values)
    return MachineShape(
        rotors, mounts, box,
        to_scale=any(body.arm for rotor in rotors for body in rotor.bodies if not result.dimensionless) or bool(places),
        pivot=directions == ["r"], is_fixed=not directions, is_shaken=is_shaken,
        foundation=any(path.startswith("carrier.foundation.") for path in values), attachments=attachments,
    )  # fmt: skip


def _rotors(bodies: list[Any], values: dict[str, float], parts: list[dict[str, Any]]) -> tuple[RotorShape, ...]:
    """The rotors on the carrier, with all bodies that turn about them, directly or through others."""
    about = {name: on for name, _, on in bodies}
    senses = {p["on"]: _sense(p, values) for p in parts if "sense" in p}

    def root(name: str) -> str:
        for _ in about:
            name = about.get(name) or name
        return name

    roots = [(name, _place(name, values)) for name, _, on in bodies if not on]
    distances = [d for k, (_, a) in enumerate(roots) for _, b in roots[:k] if (d := math.dist(a, b)) > 0]
    extent = max([*distances, *(2 * math.hypot(*place) for place in _mount_places(values))], default=0.0)
    bare_radius = min([_ROTOR * extent, *(_NEAREST * d for d in distances)]) or 1.0
    shapes = []
    for name, (x, y) in roots:
        on_it = [_body_shape(b, kind, values) for b, kind, _ in bodies if b != name and root(b) == name]
        outermost = max((max(b.arm + b.size, b.track) for b in on_it), default=0.0)
        radius = _MARGIN * outermost or bare_radius
        if on_it and not outermost:  # of a dimensionless machine: the arms have no lengths
            on_it = [BodyShape(b.name, b.kind, 0.72 * radius, 0.0, 0.0) for b in on_it]
        shapes.append(RotorShape(name, x, y, radius, senses.get(name, 0), tuple(on_it)))
    return _apart(shapes)


def _apart(rotors: list[RotorShape]) -> tuple[RotorShape, ...]:
    """Rotors at one place, of which each that follows is drawn smaller."""
    shrunk, count = [], dict[tuple[float, float], int]()
    for r in rotors:
        k = count[(r.x, r.y)] = count.get((r.x, r.y), -1) + 1
        shrunk.append(RotorShape(r.name, r.x, r.y, r.radius * 0.7**k, r.sense, r.bodies) if k and not r.bodies else r)
    return tuple(shrunk)


def _sense(drive: dict[str, Any], values: dict[str, float]) -> int:
    """The sense of a drive: as stated, or by the sign of the speed that it has without a load."""
    speeds = (values.get(f"{drive['path']}.{key}", 0.0) for key in ("no_load_speed", "speed", "set_speed", "voltage"))
    return int(drive["sense"]) * (-1 if next((v for v in speeds if v), 1.0) < 0 else 1)


def _place(name: str, values: dict[str, float]) -> tuple[float, float]:
    return values.get(f"{name}.position.x", 0.0), values.get(f"{name}.position.y", 0.0)


def _body_shape(name: str, kind: str, values: dict[str, float]) -> BodyShape:
    track, radius = values.get(f"{name}.track_radius", 0.0), values.get(f"{name}.radius", 0.0)
    if track:
        return BodyShape(name, kind, track - radius, radius, track)
    arm = next((values[f"{name}.{key}"] for key in _ARM_KEYS if f"{name}.{key}" in values), 0.0)
    pivot = math.hypot(values.get(f"{name}.suspension.x", 0.0), values.get(f"{name}.suspension.y", 0.0))
    return BodyShape(name, kind, arm + pivot, values.get(f"{name}.diameter", 0.0) / 2, 0.0)


def _mount_places(values: dict[str, float]) -> list[tuple[float, float]]:
    places, k = [], 1
    while f"carrier.mounts.{k}.at.x" in values:
        places.append((values[f"carrier.mounts.{k}.at.x"], values[f"carrier.mounts.{k}.at.y"]))
        k += 1
    return places


def _carrier_box(
    rotors: tuple[RotorShape, ...], mounts: list[tuple[float, float]], attachments: list[tuple[float, float]]
) -> tuple[float, float, float, float]:
    """The rectangle of the carrier: around its rotors, as wide as its mounts are apart."""
    pad = _CARRIER if not mounts else 1.12
    left = min([*(r.x - pad * r.radius for r in rotors), *(x for x, _ in (*mounts, *attachments))])
    right = max([*(r.x + pad * r.radius for r in rotors), *(x for x, _ in (*mounts, *attachments))])
    bottom = min([*(r.y - pad * r.radius for r in rotors), *(y for _, y in (*mounts, *attachments))])
    top = max([*(r.y + pad * r.radius for r in rotors), *(y for _, y in (*mounts, *attachments))])
    rim = 0.09 * max(right - left, top - bottom) if mounts else 0.0
    return left - rim, bottom, right + rim, top + rim / 2


def _mounts_at(
    places: list[tuple[float, float]], box: tuple[float, float, float, float], values: dict[str, float]
) -> tuple[MountShape, ...]:
    """Mounts at their places, each down to the ground, or up where it is in the upper half of the carrier."""
    middle = (box[1] + box[3]) / 2
    return tuple(
        MountShape(
            x, y, 0.0, 1.0 if y > middle and y >= 0.98 * box[3] else -1.0, _is_damped(f"carrier.mounts.{k}.", values), str(k)
        )
        for k, (x, y) in enumerate(places, 1)
    )


def _is_damped(prefix: str, values: dict[str, float]) -> bool:
    return any(values.get(f"{prefix}damping{end}", 0.0) > 0 for end in ("", ".x", ".y"))


def _springs(
    directions: list[str], box: tuple[float, float, float, float], values: dict[str, float], *, dimensionless: bool
) -> tuple[MountShape, ...]:
    """Springs of a carrier without mounts: one for each direction in which it translates."""
    has_damper = dimensionless or _is_damped("carrier.", values)
    x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    shapes = {"x": MountShape(box[0], y, -1.0, 0.0, has_damper), "y": MountShape(x, box[1], 0.0, -1.0, has_damper)}
    return tuple(shapes[d] for d in directions if d in shapes)


def draw_machine(result: Any) -> Figure | None:
    """Draw the machine of a result.

    Parameters
    ----------
    result : xarray.Dataset

    Returns
    -------
    matplotlib.figure.Figure or None
        None where the result has no machine, or was written by a version that did not record its parts.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shape = machine_shape(result.wucht)
    if shape is None:
        return None
    with page_context(REPORT):
        figure = Figure(figsize=(_INCHES, _LARGEST_HEIGHT), dpi=REPORT.dpi)
        FigureCanvasAgg(figure)
        axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axis.set_aspect("equal", adjustable="box")
        axis.set_axis_off()
        _draw(axis, shape)
        x, y = axis.dataLim.intervalx, axis.dataLim.intervaly
        scale = min(_INCHES / (x[1] - x[0]), _LARGEST_HEIGHT / (y[1] - y[0]))
        figure.set_size_inches(max((x[1] - x[0]) * scale, 1.0), max((y[1] - y[0]) * scale, 1.0))
        axis.set(xlim=x, ylim=y)
    return figure


def _draw(axis: Axes, shape: MachineShape) -> None:
    from matplotlib.patches import FancyBboxPatch

    left, bottom, right, top = shape.box
    unit = shape.size
    rounding = 0.05 * unit
    box = FancyBboxPatch(
        (left + rounding, bottom + rounding), right - left - 2 * rounding, top - bottom - 2 * rounding,
        boxstyle=f"round,pad={rounding}", facecolor="#F1F3F5", edgecolor="black", linewidth=1.1, zorder=1,
    )  # fmt: skip
    axis.add_patch(box)
    for mount in shape.mounts:
        _draw_mount(axis, mount, 0.3 * unit, 0.055 * unit, foundation=shape.foundation and mount.dy < 0)
    if shape.pivot:
        _draw_pivot(axis, 0.0, bottom, 0.12 * unit)
    if shape.is_fixed:
        _draw_ground(axis, (left + right) / 2, bottom, 0.0, -1.0, 0.45 * unit)
    for rotor in shape.rotors:
        _draw_rotor(axis, rotor, unit)
    for name, x, y in shape.attachments:
        if x is not None and y is not None:
            axis.plot([x], [y], marker="s", markersize=5, color=COLOURS[1], zorder=6)
            axis.annotate(name, (x, y), (0, -9), textcoords="offset points", **_AT_CENTRE, zorder=8)
    lines = [name for name, x, _ in shape.attachments if x is None] + ["prescribed motion"] * shape.is_shaken
    for k, line in enumerate(reversed(lines)):
        axis.text((left + right) / 2, top + (0.05 + 0.08 * k) * unit, line, **_AT_CENTRE)
        axis.update_datalim([(left, top + (0.1 + 0.08 * k) * unit)])
    _draw_scale(axis, shape)


def _draw_mount(axis: Axes, mount: MountShape, length: float, width: float, *, foundation: bool) -> None:
    """A spring, beside it a damper where there is damping, and the ground."""
    along, across = (mount.dx, mount.dy), (-mount.dy, mount.dx)

    def at(s: float, t: float) -> tuple[float, float]:
        return mount.x + s * along[0] + t * across[0], mount.y + s * along[1] + t * across[1]

    def line(points: list[tuple[float, float]], **look: Any) -> None:
        axis.plot(*zip(*(at(s, t) for s, t in points), strict=True), **_LINE | look, zorder=3)

    spring = -width if mount.has_damper else 0.0
    turns = [(length * (0.2 + 0.6 * k / 12), spring + width * 0.6 * (-1) ** k * (0 < k < 12)) for k in range(13)]
    line([(0.0, spring), (0.2 * length, spring), *turns, (length, spring)])
    if mount.has_damper:
        line([(0.0, width), (0.5 * length, width)])
        line([(0.5 * length, 0.45 * width), (0.5 * length, 1.55 * width)])
        line(
            [
                (0.38 * length, 0.3 * width),
                (0.65 * length, 0.3 * width),
                (0.65 * length, 1.7 * width),
                (0.38 * length, 1.7 * width),
            ]
        )
        line([(0.65 * length, width), (length, width)])
    x, y = at(length, 0.0)
    if foundation:
        from matplotlib.patches import Rectangle

        half = 5 * width
        axis.add_patch(
            Rectangle((x - half, y - 2 * width), 2 * half, 2 * width, facecolor="#DADDE0", edgecolor="black", zorder=2)
        )
        axis.text(x, y - width, "foundation", **_AT_CENTRE, zorder=7)
        below = MountShape(x, y - 2 * width, 0.0, -1.0, mount.has_damper)
        _draw_mount(axis, below, length, width, foundation=False)
        return
    _draw_ground(axis, x, y, *along, 5 * width)
    if mount.name:
        axis.text(*at(length * 1.3, 0.0), f"mount {mount.name}", **_AT_CENTRE, zorder=7)


def _draw_ground(axis: Axes, x: float, y: float, dx: float, dy: float, width: float) -> None:
    """A hatched line across a direction."""
    count, depth = 6, 0.16 * width
    axis.plot([x + dy * width / 2, x - dy * width / 2], [y - dx * width / 2, y + dx * width / 2], **_LINE, zorder=3)
    for k in range(count):
        t = width * ((k + 0.8) / count - 0.5)
        x0, y0 = x - dy * t, y + dx * t
        axis.plot([x0, x0 + depth * (dx + dy)], [y0, y0 + depth * (dy - dx)], **_LINE | {"linewidth": 0.6}, zorder=3)


def _draw_pivot(axis: Axes, x: float, y: float, size: float) -> None:
    axis.plot([x, x - size / 2, x + size / 2, x], [y, y - size, y - size, y], **_LINE, zorder=3)
    _draw_ground(axis, x, y - size, 0.0, -1.0, 2 * size)


def _draw_rotor(axis: Axes, rotor: RotorShape, unit: float) -> None:
    from matplotlib.patches import Circle, FancyArrowPatch

    x, y, r = rotor.x, rotor.y, rotor.radius
    axis.add_patch(Circle((x, y), r, facecolor="white", edgecolor="black", linewidth=1.1, zorder=2))
    for track in sorted({b.track for b in rotor.bodies if b.track}):
        axis.add_patch(Circle((x, y), track, facecolor="none", edgecolor=GREY, linewidth=0.8, zorder=2.5))
    axis.plot([x], [y], marker="+", markersize=7, color="black", markeredgewidth=0.9, zorder=5)
    axis.plot([x + 0.5 * r], [y], marker="o", markersize=5, color="black", zorder=5)
    axis.plot([x, x + 0.5 * r], [y, y], **_LINE | {"linewidth": 0.6}, zorder=4)
    if rotor.sense:
        ends = [(x + 0.3 * r * math.cos(a), y + 0.3 * r * math.sin(a)) for a in (math.radians(35), math.radians(145))]
        start, end = ends if rotor.sense > 0 else reversed(ends)
        bend = 0.5 * rotor.sense
        axis.add_patch(FancyArrowPatch(
            start, end, connectionstyle=f"arc3,rad={bend}", arrowstyle="-|>", mutation_scale=7, linewidth=0.9,
            color=COLOURS[1], zorder=5,
        ))  # fmt: skip
    _draw_bodies(axis, rotor, unit)
    axis.text(x, y - r - 0.05 * unit, rotor.name, **_AT_CENTRE, zorder=8)


def _draw_bodies(axis: Axes, rotor: RotorShape, unit: float) -> None:
    from matplotlib.patches import Circle

    x, y, count = rotor.x, rotor.y, len(rotor.bodies)
    for k, body in enumerate(rotor.bodies):
        angle = _FIRST_BODY + 2 * math.pi * k / count
        bx, by = x + body.arm * math.cos(angle), y + body.arm * math.sin(angle)
        if not body.track:
            axis.plot([x, bx], [y, by], color=COLOURS[0], linewidth=1.4, zorder=3)
        size = body.size or 0.035 * unit
        axis.add_patch(Circle((bx, by), size, facecolor=COLOURS[0], edgecolor="black", linewidth=0.6, zorder=6))
        inward = body.arm > 0.45 * rotor.radius
        at = body.arm - size - 0.055 * unit if inward else body.arm + size + 0.055 * unit
        axis.text(
            x + at * math.cos(angle), y + at * math.sin(angle), body.name, **_AT_CENTRE, zorder=7, bbox=_BACKGROUND,
        )  # fmt: skip


def _draw_scale(axis: Axes, shape: MachineShape) -> None:
    """A length to compare with, below the machine on the right; and room around everything."""
    axis.autoscale_view()
    x, y = axis.dataLim.intervalx, axis.dataLim.intervaly
    pad = 0.05 * max(x[1] - x[0], y[1] - y[0])
    if shape.to_scale:
        length = _round_length(0.3 * shape.size)
        right, low = x[1] + 0.4 * length, y[0] + pad
        axis.plot([right, right + length], [low, low], **_LINE | {"linewidth": 1.6}, zorder=3)
        for end in (right, right + length):
            axis.plot([end, end], [low - 0.25 * pad, low + 0.25 * pad], **_LINE, zorder=3)
        text = f"{length * 1e3:g} mm" if length < 1.0 else f"{length:g} m"
        axis.text(right + length / 2, low + 0.5 * pad, text, ha="center", va="bottom", fontsize=REPORT.small)
        x = (x[0], max(x[1], right + length))
    axis.update_datalim([(x[0] - pad, y[0] - 1.2 * pad), (x[1] + pad, y[1] + pad)])


def _round_length(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is no more than a length."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(n * power for n in (1.0, 2.0, 5.0) if n * power <= length * (1 + 1e-9))
