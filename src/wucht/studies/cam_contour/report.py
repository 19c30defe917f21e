"""The answer of a cam's contour in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import in_lines

if TYPE_CHECKING:
    import xarray as xr

_DECIMALS = 9  # of lengths in mm: what is less is rounding
_CALLED = {"cam": "cam", "counter": "counter cam", "outer": "outer flank"}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a cam's contour."""
    s = result.wucht.summary
    lines: list[tuple[str, str]] = []
    for name, cam in s["cams"].items():
        lines += _of_cam(_CALLED[name], cam)
    if s["min_transmission_angle"] is not None:
        lines.append(("transmission", f"angle of the linkage at least {_degrees(s['min_transmission_angle'])}"))
    if s["contact"] is not None:
        lines += _contact(s["contact"], "N m" if result.follower.attrs["units"] == "rad" else "N")
    if s["smallest"] is not None:
        lines.append(("smallest cam", _smallest(s["smallest"])))
    count = sum(cam["points_to_mill"] for cam in s["cams"].values())
    if count:
        tolerance = f"chords within {1e6 * s['chord_tolerance']:.4g} um, {s['decimals']} decimals in mm"
        lines.append(("to mill", f"{count} points, {tolerance}"))
    return in_lines(result, s["sentence"], lines)


def _of_cam(name: str, cam: dict[str, Any]) -> list[tuple[str, str]]:
    least = "least radius" if name == _CALLED["outer"] else "base circle"
    circles = f"{least} {_millimetres(cam['base_radius'])}, largest radius {_millimetres(cam['largest_radius'])}"
    angle = cam["max_pressure_angle"]
    if angle["angle"]:
        circles += f", pressure angle at most {_degrees(angle['angle'])} at {_degrees(angle['at'])}"
    lines = [(name, circles), ("", f"convex {_radius(cam['min_curvature'])}; hollow {_radius(cam['min_hollow'])}")]
    if cam["largest_roller"] is not None:
        lines.append(("", f"roller at most {_millimetres(cam['largest_roller'])}, or it cuts the contour away"))
    if cam["largest_wheel"] is not None:
        wheel = cam["largest_wheel"]
        lines.append(("", f"grinding wheel at most {_millimetres(wheel['radius'])} (at {_degrees(wheel['at'])})"))
    return lines


def _contact(contact: dict[str, Any], unit: str) -> list[tuple[str, str]]:
    forces = contact["max_force"].items()
    preload = f"at least {contact['least_preload']:.4g} {unit} to"
    if not any(p["value"] for _, p in forces):
        return [("contact", "nowhere: the follower does not touch its cam"), ("preload", f"{preload} keep contact")]
    shown = ", ".join(f"{_of(name, forces)}at most {p['value']:.4g} N at {_degrees(p['at'])}" for name, p in forces)
    lines = [("contact", f"{shown}, at {contact['mean_speed'] * 30 / math.pi:.4g} rpm")]
    if contact["max_pressure"]:
        peaks = contact["max_pressure"].items()
        pressures = (f"{_of(name, peaks)}at most {p['value'] / 1e6:.4g} MPa at {_degrees(p['at'])}" for name, p in peaks)
        lines.append(("Hertz", ", ".join(pressures)))
    torque = contact["max_torque"]
    lines.append(("camshaft", f"torque at most {torque['value']:.4g} N m at {_degrees(torque['at'])}"))
    kept = "stay on the inner flank" if "outer" in contact["max_force"] else "keep contact all the way round"
    lines.append(("preload", f"{preload} {kept}"))
    return lines


def _of(name: str, among: Any) -> str:
    return f"{_CALLED[name]} " if len(among) > 1 else ""


def _smallest(found: dict[str, Any]) -> str:
    follower = ", ".join(
        f"{key} {_degrees(value) if key == 'angle' else _millimetres(value)}" for key, value in found["follower"].items()
    )
    angle = f", pressure angle {_degrees(found['max_pressure_angle'])}" if "max_pressure_angle" in found else ""
    return f"{follower}: base circle {_millimetres(found['base_radius'])}{angle}, least {_value(found['min_curvature_radius'])}"


def _radius(found: dict[str, float] | None) -> str:
    return "nowhere" if found is None else f"radius at least {_millimetres(found['radius'])} at {_degrees(found['at'])}"


def _value(radius: float | None) -> str:
    return "radius none" if radius is None else f"radius {_millimetres(radius)}"


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.4g}°"


def _millimetres(length: float) -> str:
    return f"{round(1e3 * length, _DECIMALS) + 0.0:.4g} mm"
