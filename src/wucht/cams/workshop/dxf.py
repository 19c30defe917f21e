"""CAD files: DXF with the contour as a closed polyline and as a smooth spline, the pitch curve, the base circle and the roller.

A polyline is what the oldest CAM program mills, a spline what a modern one mills best: they are on separate layers, and
the workshop takes the one or the other.
"""

from __future__ import annotations

import math
import re
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any
from uuid import NAMESPACE_URL, uuid5

import numpy as np

from wucht.cams.demands import require_finite, require_positive
from wucht.cams.workshop.closed_curve import CamCurve, PlaneSpline, curve_distances, fitted_spline
from wucht.cams.workshop.heading import Heading
from wucht.cams.workshop.points import chord_points
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
) -> None:
    """Draw a cam about the origin, in millimetres.

    tolerance: in m, kept by the chords of the polylines and by the splines. base_radius, roller_radius: in m; the roller is
    drawn where it is at phi = 0, on the pitch curve. heading: of the cam, in comments (group code 999) before the header. Its
    extents are those of all lines. Raises ``InputError``, and ``RunError`` where nothing can be written.
    """
    ezdxf = _ezdxf()
    require_positive("tolerance", tolerance)
    document = ezdxf.new(_VERSION, units=_MILLIMETRES)
    space = document.modelspace()
    for polyline, spline, curve in ((CONTOUR, CONTOUR_SPLINE, contour), (PITCH, PITCH_SPLINE, pitch)):
        if curve is not None:
            corners = 1e3 * chord_points(curve, tolerance).position
            space.add_lwpolyline([(z.real, z.imag) for z in corners], close=True, dxfattribs={"layer": polyline})
            _add_spline(space, spline, fitted_spline(curve, tolerance))
    if base_radius is not None:
        _add_circle(space, BASE_CIRCLE, 0j, require_positive("base_radius", base_radius))
    if roller_radius is not None:
        if pitch is None:
            raise InputError("roller_radius", roller_radius, "the roller is drawn on the pitch curve: give that too")
        centre = complex(require_finite("pitch", pitch(np.zeros(1)))[0])
        _add_circle(space, ROLLER, centre, require_positive("roller_radius", roller_radius))
    for layer in sorted({entity.dxf.layer for entity in space}):
        document.layers.add(layer, color=_COLOURS[layer])
    space.reset_extents(*_extents(space))
    text = _text(document, heading)
    replace_file(path, lambda beside: beside.write_bytes(document.encode(text)))


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


def _add_circle(space: Any, layer: str, centre: complex, radius: float) -> None:
    space.add_circle((1e3 * centre.real, 1e3 * centre.imag), 1e3 * radius, dxfattribs={"layer": layer})


def _add_spline(space: Any, layer: str, spline: PlaneSpline) -> None:
    entity = space.add_spline(degree=spline.degree, dxfattribs={"layer": layer})
    entity.control_points = [(1e3 * z.real, 1e3 * z.imag, 0.0) for z in spline.control]
    entity.knots = spline.knots.tolist()
    entity.dxf.flags = entity.CLOSED | entity.PLANAR


def read_dxf(path: Path) -> tuple[dict[str, np.ndarray], dict[str, PlaneSpline]]:
    """Read the closed polylines and the closed splines over 0 to 2 pi, by layer, in m. Raises ``InputError``.

    A polyline has its corners (N,), complex, each once.
    """
    ezdxf = _ezdxf()
    if not path.is_file():
        raise InputError(str(path), None, "there is no such file", code="no-file")
    try:
        document = ezdxf.readfile(path)
    except (OSError, UnicodeDecodeError, ezdxf.DXFError) as error:
        raise InputError(str(path), None, f"it is not a readable DXF file: {error}", code="unreadable") from None
    if document.header.get("$INSUNITS", 0) != _MILLIMETRES:
        raise InputError(str(path), None, "its header must state millimetres ($INSUNITS = 4)", code="unit")
    polylines, splines = dict[str, np.ndarray](), dict[str, PlaneSpline]()
    for entity in document.modelspace():
        layer, kind = entity.dxf.layer, entity.dxftype()
        if kind == "LWPOLYLINE" and entity.closed:
            polylines[layer] = np.array([x + 1j * y for x, y in entity.get_points("xy")]) / 1e3
        elif kind == "SPLINE" and entity.closed and _spans_turn(entity):
            control = np.array([v[0] + 1j * v[1] for v in entity.control_points]) / 1e3
            splines[layer] = PlaneSpline(entity.dxf.degree, np.array(entity.knots), control)
    return polylines, splines


def _spans_turn(spline: Any) -> bool:
    knots = spline.knots
    return len(knots) > 0 and not len(spline.weights) and math.isclose(knots[-1] - knots[0], 2 * math.pi, rel_tol=1e-9)


def read_back(path: Path, contour: CamCurve, pitch: CamCurve | None = None) -> dict[str, tuple[int, float]]:
    """Read a file that ``write_dxf`` wrote, and measure its lines.

    Returns, by layer, the number of points or pieces, and the largest distance in m from the curve. Raises ``InputError``.
    """
    polylines, splines = read_dxf(path)
    lines = dict[str, tuple[int, float]]()
    for polyline, spline, curve in ((CONTOUR, CONTOUR_SPLINE, contour), (PITCH, PITCH_SPLINE, pitch)):
        if curve is None:
            continue
        if polyline not in polylines or spline not in splines:
            raise InputError(
                str(path),
                None,
                f"the layers {polyline} and {spline} must hold a closed polyline and a closed spline",
                code="no-layers",
            )
        corners, smooth = polylines[polyline], splines[spline]
        shares = np.arange(_BETWEEN) / _BETWEEN
        on_chords = corners[:, None] + (np.roll(corners, -1) - corners)[:, None] * shares
        on_spline = smooth(even_angles(max(_SAMPLES, _BETWEEN * smooth.pieces)))
        lines[polyline] = len(corners), float(curve_distances(curve, on_chords.ravel()).max())
        lines[spline] = smooth.pieces, float(curve_distances(curve, on_spline).max())
    return lines
