"""The smallest cam for a permitted pressure angle and a permitted curvature, of a follower with a roller.

The smallest cam for a permitted curvature alone is computed by a search of the plane.
The curvature of the pitch curve is (|V|^2 -+ Im(V* A'))/|V|^3 with V = A - O. That it is at most 1/rho forbids O a bounded
region about each A: what remains is not convex, but never empty. There the plane is searched, on rays from the point in
question: each meets K in one piece, and beyond a known radius the curvature forbids nothing. Between the rays beside the best
ones the search goes on by golden sections, with exchange of cam angles, to some 1e-9. It is as good as its rays: a better
cam in a gap of what is forbidden that is narrower than 1.5 deg, or than 1/160 of a ray, could be missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.laws.cone_programme import InfeasibleError
from wucht.cams.sizing.layout import EXACT, Layout, minima_below, nearest_in_cones, pitch_curvature
from wucht.cams.sizing.size_limits import LARGEST_ANGLE, Size, SmallestCam
from wucht.errors import InputError, RunError
from wucht.numerics.angles import GRID, TURN, refine_minima, valleys

_BINDING = 1e-6  # of the curvature: tolerance within which a bound is reached
_MOST_EXCHANGES = 60
_FINE = np.geomspace(1e-5, 0.03, 24)  # rad: K may be a thin wedge
_RAYS = np.sort(np.concatenate([-_FINE, _FINE, np.arange(-120, 120) * (TURN / 240)]))
_ALONG = np.linspace(0.0, 1.0, 160)  # of a ray
_HALVINGS = 34
_PROMISING = 1.05  # times the best of the rays: it may become the best between them
_COARSE = GRID[::16]
_MOST_STARTS = 3
Angles = float | tuple[float, float]
LEAST_DISTANCE = 1e-6  # m: a cam file wants a distance greater than zero, even of a law that is never zero
_SHARE = 1e-9  # of the tangents of the pressure angles: accuracy where a shaft makes them smaller


def _point_with_curvature(layout: Layout, target: complex, centre: complex, most: float) -> complex:
    """Return the point of K nearest to a target where the pitch curve is nowhere bent more sharply; ``centre``: of K alone."""
    if not len(_sharper_angles(layout, centre, most)):
        return centre
    rays = _Rays(target, most, *layout.bends(_COARSE), *layout.half_planes(_COARSE))
    points = [_refined_point(layout, rays, between) for between in _first_points(layout, rays, centre)]
    feasible = [z for z in points if z is not None]
    if not feasible:
        raise RunError("no cam of that least radius was found: permit a smaller radius, or a larger pressure angle")
    return min(feasible, key=lambda z: abs(z - target))


def _sharper_angles(layout: Layout, centre: complex, most: float) -> np.ndarray:
    def room(phi: np.ndarray) -> np.ndarray:
        apex, apex_slope = layout.bends(phi)
        return np.asarray(1 - pitch_curvature(apex - centre, apex_slope) / most)

    return minima_below(room(GRID), room, -100 * EXACT)


@dataclass(frozen=True, eq=False)
class _Rays:
    """Rays from a target, and their feasible points at some cam angles. apex, apex_slope, a, b: of those angles."""

    target: complex
    most: float
    apex: np.ndarray
    apex_slope: np.ndarray
    a: np.ndarray
    b: np.ndarray

    def with_angles(self, layout: Layout, phi: np.ndarray) -> _Rays:
        """Return the rays with further cam angles."""
        old, new = (self.apex, self.apex_slope, self.a, self.b), (*layout.bends(phi), *layout.half_planes(phi))
        return _Rays(self.target, self.most, *(np.append(o, n) for o, n in zip(old, new, strict=True)))

    def worst(self, ray: complex, at: np.ndarray) -> np.ndarray:
        """The largest curvature at distances (N,) along a ray."""
        return np.asarray(pitch_curvature(self.apex - (self.target + at * ray)[:, None], self.apex_slope).max(axis=1))

    @cached_property
    def free_distance(self) -> float:
        """The distance beyond which the curvature forbids nothing.

        |V|^2 + |V||A'| <= most |V|^3 is true beyond the positive root.
        """
        largest = 4 * self.most * float(np.abs(self.apex_slope).max())
        return float(np.abs(self.target - self.apex).max()) + (1 + math.sqrt(1 + largest)) / (2 * self.most)

    def feasible_distance(self, angle: float) -> float:
        """Return the least feasible distance on a ray: the first feasible sample, refined by bisection; infinite: none."""
        ray = complex(math.cos(angle), math.sin(angle))
        slope, room = (ray * self.a.conj()).real, self.b - (self.target * self.a.conj()).real
        enter = float(np.max(room[slope < 0] / slope[slope < 0], initial=0.0))
        leave = float(np.min(room[slope > 0] / slope[slope > 0], initial=max(enter, self.free_distance)))
        if enter > leave * (1 + _BINDING):
            return math.inf
        at = enter + (leave - enter) * _ALONG
        feasible = np.flatnonzero(self.worst(ray, at) <= self.most)
        if not len(feasible) or feasible[0] == 0:
            return float(at[0]) if len(feasible) else math.inf
        low, high = float(at[feasible[0] - 1]), float(at[feasible[0]])
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (low, middle) if self.worst(ray, np.array([middle]))[0] <= self.most else (middle, high)
        return high


def _first_points(layout: Layout, rays: _Rays, centre: complex) -> list[tuple[float, float]]:
    """Return the angles of the rays before and behind each locally best ray, the nearest point first."""
    middle = layout.inward * layout.guide.rate(np.array(sum(layout.range) / 2))
    toward = np.angle(centre - rays.target)
    angles = toward + np.sort(np.append(_RAYS, np.angle(middle / (centre - rays.target))))  # to the middle all cones open
    first = np.array([rays.feasible_distance(angle) for angle in angles])
    best = np.flatnonzero(np.isfinite(first) & (first <= np.roll(first, 1)) & (first <= np.roll(first, -1)))
    best = best[np.argsort(first[best])]
    best = best[first[best] <= _PROMISING * first[best[:1]]][:_MOST_STARTS]
    around = np.concatenate([[angles[-1] - TURN], angles, [angles[0] + TURN]])
    return [(float(around[k]), float(around[k + 2])) for k in best]


def _refined_point(layout: Layout, rays: _Rays, between: tuple[float, float]) -> complex | None:
    """Return the nearest feasible point between two rays, None if the refinement fails."""
    begin, end = (np.array([angle]) for angle in between)
    for _ in range(_MOST_EXCHANGES):

        def distances(angles: np.ndarray, rays: _Rays = rays) -> np.ndarray:
            return np.array([rays.feasible_distance(float(angle)) for angle in angles])

        angle = float(refine_minima(distances, begin, end)[0])
        distance = rays.feasible_distance(angle)
        if not math.isfinite(distance):
            return None
        z = rays.target + distance * complex(math.cos(angle), math.sin(angle))
        new = np.concatenate([layout.violated_angles(z), _sharper_angles(layout, z, rays.most)])
        if not len(new):
            return z
        rays = rays.with_angles(layout, new)
    return None


def check_length(name: str, value: float, or_zero: bool = False) -> None:
    """Raise ``InputError`` where a length in m is not finite, or not above zero."""
    if not (math.isfinite(value) and (value > 0 or (or_zero and value == 0))):
        raise InputError(name, value, f"must be {'zero or ' if or_zero else ''}greater than zero (in m)")


def tangents_of(pressure_angles: Angles) -> tuple[float, float]:
    """Return the tangents of the pressure angles as the roller goes out and in. Raises ``InputError``."""
    angles = pressure_angles if isinstance(pressure_angles, tuple) else (pressure_angles, pressure_angles)
    for angle in angles:
        if not 0 < angle <= LARGEST_ANGLE:
            raise InputError("pressure_angle", angle, "must be greater than zero and at most 89 deg (in rad)")
    return math.tan(angles[0]), math.tan(angles[1])


def smallest_roller_cam(layout: Layout, least_radius: float | None, shaft_radius: float | None, size: Size) -> SmallestCam:
    """Return the smallest cam of a layout, see ``smallest_lever_cam``. Raises ``InputError``, ``RunError``."""
    roller = layout.guide.roller_radius
    check_length("roller_radius", roller, or_zero=True)
    if least_radius is not None:
        check_length("least_radius", least_radius, or_zero=roller > 0)
    target = layout.ends[0 if size == "base" else 1]

    def centre_for(layout: Layout) -> complex:
        nearest = nearest_in_cones(layout, target)
        return nearest if least_radius is None else _point_with_curvature(layout, target, nearest, 1 / (roller + least_radius))

    try:
        centre = centre_for(layout)
    except InfeasibleError:
        swing, pressure_angle = layout.swing, math.atan(min(layout.tangents))
        requirement = f"no cam can keep it: it must be greater than {math.degrees(swing) / 2:.6g} deg, half the lever's swing"
        raise InputError("pressure_angle", f"{math.degrees(pressure_angle):.6g} deg", requirement) from None
    if shaft_radius is not None:
        check_length("shaft_radius", shaft_radius, or_zero=True)
        centre = _centre_around_shaft(layout, centre, roller + shaft_radius, centre_for)
    return _cam_at_centre(layout, centre)


def _centre_around_shaft(layout: Layout, centre: complex, base: float, centre_for: Callable[[Layout], complex]) -> complex:
    """Return the centre of a cam whose pitch curve has at least a base circle, and a rod's a distance greater than zero.

    Of the cams with that base circle the one with the smallest pressure angle is taken. The smaller that is, the larger
    is the smallest cam, without limit towards half the lever's swing.
    """

    def clears_shaft(centre: complex) -> bool:
        return abs(layout.ends[0] - centre) >= base and layout.guide.distance_from(centre) >= LEAST_DISTANCE

    if clears_shaft(centre):
        return centre
    best: complex | None = None
    low, high = math.tan(layout.swing / 2) / min(layout.tangents), 1.0  # of the tangents: at low the cam is infinitely large
    while high - low > _SHARE:
        share = (low + high) / 2
        try:
            trial = centre_for(replace(layout, tangents=(share * layout.tangents[0], share * layout.tangents[1])))
        except InfeasibleError:  # by rounding, so near to half the swing
            low = share
            continue
        low, high, best = (share, high, trial) if clears_shaft(trial) else (low, share, best)
    if best is None:
        raise RunError("no cam round a shaft of that radius was found: permit a smaller radius", code="no-cam")
    return best


def _cam_at_centre(layout: Layout, centre: complex) -> SmallestCam:
    """Return the cam whose centre is O, turned and moved so that O is 0 and the pivot on +x, or the rod along +x."""
    follower = layout.guide.relative_to(centre)
    cam = RollerCam(layout.law, follower, layout.clockwise)

    def spare(phi: np.ndarray) -> np.ndarray:
        return np.asarray(np.arctan(layout.cones(phi)[2]) - np.abs(cam.pressure_angle(phi)))

    at, spares = valleys(spare)
    largest = -float(valleys(lambda phi: -np.abs(cam.pressure_angle(phi)))[1].min())
    sharpest, bends = valleys(lambda phi: -cam.pitch_curvature(phi))
    k = int(np.argmin(bends))
    radius = -1 / float(bends[k]) - follower.roller_radius if bends[k] < 0 else math.inf
    near, far = (abs(end - centre) for end in layout.ends)
    binding = tuple(float(x) for x in np.sort(at[spares < _BINDING]))
    return SmallestCam(follower, near, far, radius, float(sharpest[k]), follower.roller_radius, largest, binding)
