"""What studies of cam drives state alike: laws and motions with their derivatives, contours of cams, and lengths in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.laws import Law
from wucht.cams.shape import COMMON
from wucht.cams.tables.motion_law import MotionLaw
from wucht.plots.cam_drawings import LAW_NAMES, PER_ANGLE
from wucht.studies.answer import Answer

_KILO = 1e3
_ROUNDING = 1e-9  # of the stroke: a distance from the law that is none
_DECIMALS = 9  # of lengths in mm: smaller differences are rounding


def _pitch(cam: Cam, phi: np.ndarray) -> np.ndarray:
    """Return the pitch curve, complex in m; not numbers for a flat face."""
    return np.full(len(phi), np.nan + 0j) if cam.pitch_curve is None else cam.pitch_curve(phi, 0)


CURVES: Mapping[str, tuple[str, str, Callable[[Cam, np.ndarray], np.ndarray]]] = {
    "contour_x": ("contour, x", "m", lambda cam, phi: cam.contour(phi).real),
    "contour_y": ("contour, y", "m", lambda cam, phi: cam.contour(phi).imag),
    "pitch_x": ("pitch curve, x", "m", lambda cam, phi: _pitch(cam, phi).real),
    "pitch_y": ("pitch curve, y", "m", lambda cam, phi: _pitch(cam, phi).imag),
    "normal_x": ("normal, x", "", lambda cam, phi: cam.normal(phi).real),
    "normal_y": ("normal, y", "", lambda cam, phi: cam.normal(phi).imag),
    "curvature": ("curvature of the contour", "1/m", lambda cam, phi: cam.material * cam.curvature(phi)),
    "uncut": ("margin against undercut, 0 at an edge", "", lambda cam, phi: cam.undercut(phi)),
    "pressure_angle": ("pressure angle", "rad", lambda cam, phi: cam.pressure_angle(phi)),
}


def warn_of_jumps(a: Answer, law: MotionLaw) -> None:
    """Warn of a law whose acceleration jumps."""
    if law.jump:
        a.warn(
            f"the acceleration jumps {law.jump_places}, and the jerk has no bound there: suitable for slow shafts only; "
            "polynomial and sine laws have no jumps"
        )


def state_law(a: Answer, law: Law, angles: np.ndarray, what: str, unit: str) -> None:
    """State a law at cam angles (N,), and its derivatives. what: the law in words."""
    for order, (name, per) in enumerate(zip(LAW_NAMES, PER_ANGLE, strict=True)):
        long_name = f"{name} with respect to the cam angle" if order else what
        a.curve(name, law(angles, order), long_name, unit + per, "cam_angle")


def state_motion(a: Answer, name: str, derivatives: Iterable[Any], what: str, unit: str, over: str = "cam_angle") -> None:
    """State a motion with its derivatives by the cam angle, from order 0 on, as variables whose names begin alike."""
    for order, values in enumerate(derivatives):
        suffix = LAW_NAMES[order] if order else ""
        a.curve(
            f"{name}_{suffix}" if order else name, values, f"{what}, {suffix}" if order else what, unit + PER_ANGLE[order], over
        )


def state_cam_curves(
    a: Answer, names: Iterable[str], cams: Sequence[Cam], phi: np.ndarray, over: str, shape: tuple[int, ...]
) -> None:
    """State curves of cams at cam angles (N,), in the plane that turns with them.

    names: of these variables. over: their dimensions, and shape: that of the array of each.
    """
    for name in names:
        what, unit, get_curve = CURVES[name]
        a.curve(name, np.array([get_curve(cam, phi) for cam in cams]).reshape(shape), what, unit, over)


def state_rollers(a: Answer, cams: Iterable[Cam]) -> None:
    """State the radius of the roller of each cam."""
    radii = [math.nan if cam.roller_radius is None else cam.roller_radius for cam in cams]
    a.curve("roller_radius", np.array(radii, float), "radius of the roller", "m", "cam")


def state_common_pressure_angle(a: Answer, follower_unit: str) -> None:
    """State the pressure angle that a follower commonly has, which turns (rad) or slides (m)."""
    a.curve("common_pressure_angle", COMMON[follower_unit], "usual upper limit of the pressure angle", "rad", "")


def power_numbers(power: np.ndarray) -> dict[str, float]:
    """Return peak, mean, and mean of the positive part over a turn of evenly spaced points, the last equal to the first."""
    samples = power[:-1]
    return {
        "peak": float(samples.max()),
        "mean": float(samples.mean()),
        "mean_positive": float(np.maximum(samples, 0.0).mean()),
    }


def demand_text(power: Mapping[str, float]) -> str:
    """Return peak and mean of the positive part of a power as text."""
    return f"{watts_text(power['peak'])} at most, {watts_text(power['mean_positive'])} on average without power flowing back"


def watts_text(power: float) -> str:
    """Return a power in W as text."""
    return f"{power / _KILO:.4g} kW" if abs(power) >= _KILO else f"{power:.4g} W"


def pad_orders(values: np.ndarray, count: int) -> np.ndarray:
    """Return values (N,) of orders cut to a count, or filled up with what is not a number."""
    return np.append(values[:count], np.full(max(0, count - len(values)), np.nan))


def distance_text(distance: float, unit: str, stroke: float) -> str:
    """Return how far an output is off, in rad or m, as text in degrees or mm; 0 where that is rounding of the stroke."""
    size = 0.0 if distance < _ROUNDING * stroke else distance
    return f"{math.degrees(size):.4g}°" if unit == "rad" else f"{1e3 * size:.4g} mm"


def length_text(length: float | None) -> str:
    """Return a length in m as text, in mm."""
    return "none" if length is None else f"{round(1e3 * length, _DECIMALS) + 0.0:.4g} mm"


def angle_text(angle: float) -> str:
    """Return an angle in rad as text, in degrees."""
    return f"{math.degrees(angle):.4g}°"
