"""CAD files: DXF with the contour as a closed polyline and as a smooth spline, the pitch curve, the base circle and the roller.

A polyline is what the oldest CAM program mills, a spline what a modern one mills best: they are on separate layers, and
the workshop takes the one or the other.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any
from uuid import NAMESPACE_URL, uuid5

import numpy as np

from wucht.cams.demands import require_finite, require_positive
from wucht.cams.workshop.closed_curve import CamCurve, PlaneSpline, curve_distances, fitted_spline, spline_deviation
from wucht.cams.workshop.heading import Heading
from wucht.cams.workshop.points import chord_deviation, chord_points
from wucht.errors import InputError
from wucht.numerics.fourier_series import even_angles
from wucht.results.store import replace_file

CONTOUR, CONTOUR_SPLINE = "CONTOUR", "CONTOUR_SPLINE"
PITCH, PITCH_SPLINE = "PITCH_CURVE", "PITCH_CURVE_SPLINE"
BASE_CIRCLE, ROLLER = "BASE_CIRCLE", "ROLLER"
_COLOURS = {CONTOUR: 7, CONTOUR_SPLINE: 3, PITCH: 8, PITCH_SPLINE: 4, BASE_CIRCLE: 5, ROLLER: 1}
_VERSION = "R2000"  # the oldest that states units and has both entities; every program reads it
_MILLIMETRES = 4  # of $INSUNITS
_DATES = re.compile(r"(\$TD(?:CREATE|UCREATE|UPDATE|UUPDATE)\n *40\n)[^\n]*")
_IDENTIFIERS = re.compile(r"(\$(?:FINGERPRINT|VERSION)GUID\n *2\n)[^\n]*")
_WRITING_TIME = re.compile(r"(\n[\d.]+ @ )\d{4}-[^\n]*")  # of ezdxf, in the dictionary of its data
_BETWEEN = 16
_SAMPLES = 4096


@dataclass(frozen=True)
class DrawnLine:
    """A line on a layer: its number of points or pieces, and its largest distance, in m, from its curve."""

    layer: str
    count: int
    deviation: float


@dataclass(frozen=True, eq=False)
class Circle:
    """centre: x + i y in m. radius: in m."""

    centre: complex
    radius: float


@dataclass(frozen=True, eq=False)
class Drawing:
    """Content read from a file, by layer, in m. polylines: the corners (N,), complex, each once."""

    polylines: dict[str, np.ndarray]
    splines: dict[str, PlaneSpline]
    circles: dict[str, Circle]


def _ezdxf() -> Any:
    try:
        return import_module("ezdxf")
    except ImportError:
        raise InputError("dxf", None, "DXF files need the extra: pip install wucht[cad]") from None


def write_dxf(
    path: Path,
    contour: CamCurve,
    tolerance: float,
    pitch: CamCurve | None = None,
    base_radius: float | None = None,
    roller_radius: float | None = None,
    heading: Heading | None = None,
) -> tuple[DrawnLine, ...]:
    """Draw a cam about the origin, in millimetres, and return the deviation of each line from its curve.

    tolerance: in m, kept by the chords of the polylines and by the splines. base_radius, roller_radius: in m; the roller is
    drawn where it is at phi = 0, on the pitch curve. heading: of the cam, in comments (group code 999) before the header. Its
    extents are those of all lines. Raises ``InputError``, and ``RunError`` where nothing can be written.
    """
    ezdxf = _ezdxf()
    require_positive("tolerance", tolerance)
    document = ezdxf.new(_VERSION, units=_MILLIMETRES)
    space = document.modelspace()
    lines: list[DrawnLine] = []
    for polyline, spline, curve in ((CONTOUR, CONTOUR_SPLINE, contour), (PITCH, PITCH_SPLINE, pitch)):
        if curve is not None:
            lines += [_polyline(space, polyline, curve, tolerance), _spline(space, spline, curve, tolerance)]
    for layer, circle in _circles(pitch, base_radius, roller_radius):
        centre = (1e3 * circle.centre.real, 1e3 * circle.centre.imag)
        space.add_circle(centre, 1e3 * circle.radius, dxfattribs={"layer": layer})
    for layer in sorted({entity.dxf.layer for entity in space}):
        document.layers.add(layer, color=_COLOURS[layer])
    space.reset_extents(*_extents(space))
    text = _text(document, heading)
    replace_file(path, lambda beside: beside.write_bytes(document.encode(text)))
    return tuple(lines)


def _extents(space: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return the least and the greatest coordinates in mm of all lines."""
    from ezdxf.bbox import extents

    box = extents(space)
    return tuple(box.extmin), tuple(box.extmax)


def _text(document: Any, heading: Heading | None) -> str:
    """Return the drawing as text, with the heading in comments: with equal headings equal drawings give equal texts."""
    from ezdxf.tools.juliandate import juliandate

    stream = StringIO()
    document.write(stream)
    text = stream.getvalue()
    if heading is None:
        return text
    comments = [f"{key}: {entry}" for key, entry in heading.entries.items()]
    identifier = str(uuid5(NAMESPACE_URL, "\n".join(comments))).upper()
    text = _DATES.sub(rf"\g<1>{juliandate(heading.date.replace(tzinfo=None))}", text)
    text = _IDENTIFIERS.sub(rf"\g<1>{{{identifier}}}", text)
    text = _WRITING_TIME.sub(rf"\g<1>{heading.date.isoformat()}", text)
    return "".join(f"999\n{comment}\n" for comment in comments) + text


def _polyline(space: Any, layer: str, curve: CamCurve, tolerance: float) -> DrawnLine:
    points = chord_points(curve, tolerance)
    corners = 1e3 * points.position
    space.add_lwpolyline([(z.real, z.imag) for z in corners], close=True, dxfattribs={"layer": layer})
    return DrawnLine(layer, len(corners), chord_deviation(curve, points.phi))


def _spline(space: Any, layer: str, curve: CamCurve, tolerance: float) -> DrawnLine:
    spline = fitted_spline(curve, tolerance)
    entity = space.add_spline(degree=spline.degree, dxfattribs={"layer": layer})
    entity.control_points = [(1e3 * z.real, 1e3 * z.imag, 0.0) for z in spline.control]
    entity.knots = spline.knots.tolist()
    entity.dxf.flags = entity.CLOSED | entity.PLANAR
    return DrawnLine(layer, spline.pieces, spline_deviation(curve, spline))


def _circles(pitch: CamCurve | None, base: float | None, roller: float | None) -> Iterator[tuple[str, Circle]]:
    if base is not None:
        yield BASE_CIRCLE, Circle(0j, require_positive("base_radius", base))
    if roller is not None:
        if pitch is None:
            raise InputError("roller_radius", roller, "the roller is drawn on the pitch curve: give that too")
        yield ROLLER, Circle(complex(require_finite("pitch", pitch(np.zeros(1)))[0]), require_positive("roller_radius", roller))


def read_dxf(path: Path) -> Drawing:
    """Read the closed polylines, the circles, and the closed splines over 0 to 2 pi, one a layer. Raises ``InputError``."""
    ezdxf = _ezdxf()
    if not path.is_file():
        raise InputError(str(path), None, "there is no such file", code="no-file")
    try:
        document = ezdxf.readfile(path)
    except (OSError, UnicodeDecodeError, ezdxf.DXFError) as error:
        raise InputError(str(path), None, f"it is not a readable DXF file: {error}", code="unreadable") from None
    if document.header.get("$INSUNITS", 0) != _MILLIMETRES:
        raise InputError(str(path), None, "its header must state millimetres ($INSUNITS = 4)", code="unit")
    drawing = Drawing({}, {}, {})
    for entity in document.modelspace():
        layer, kind = entity.dxf.layer, entity.dxftype()
        if kind == "LWPOLYLINE" and entity.closed:
            drawing.polylines[layer] = np.array([x + 1j * y for x, y in entity.get_points("xy")]) / 1e3
        elif kind == "SPLINE" and entity.closed and _spans_turn(entity):
            control = np.array([v[0] + 1j * v[1] for v in entity.control_points]) / 1e3
            drawing.splines[layer] = PlaneSpline(entity.dxf.degree, np.array(entity.knots), control)
        elif kind == "CIRCLE":
            drawing.circles[layer] = Circle(complex(entity.dxf.center.x, entity.dxf.center.y) / 1e3, entity.dxf.radius / 1e3)
    return drawing


def _spans_turn(spline: Any) -> bool:
    knots = spline.knots
    return len(knots) > 0 and not len(spline.weights) and math.isclose(knots[-1] - knots[0], 2 * math.pi, rel_tol=1e-9)


def read_back(path: Path, contour: CamCurve, pitch: CamCurve | None = None) -> tuple[DrawnLine, ...]:
    """Read a file that ``write_dxf`` wrote, and measure the deviations of its lines from the curves. Raises ``InputError``."""
    drawing = read_dxf(path)
    lines: list[DrawnLine] = []
    for polyline, spline, curve in ((CONTOUR, CONTOUR_SPLINE, contour), (PITCH, PITCH_SPLINE, pitch)):
        if curve is None:
            continue
        if polyline not in drawing.polylines or spline not in drawing.splines:
            raise InputError(
                str(path),
                None,
                f"the layers {polyline} and {spline} must hold a closed polyline and a closed spline",
                code="no-layers",
            )
        corners, smooth = drawing.polylines[polyline], drawing.splines[spline]
        shares = np.arange(_BETWEEN) / _BETWEEN
        on_chords = corners[:, None] + (np.roll(corners, -1) - corners)[:, None] * shares
        on_spline = smooth(even_angles(max(_SAMPLES, _BETWEEN * smooth.pieces)))
        lines += [
            DrawnLine(polyline, len(corners), float(curve_distances(curve, on_chords.ravel()).max())),
            DrawnLine(spline, smooth.pieces, float(curve_distances(curve, on_spline).max())),
        ]
    return tuple(lines)
