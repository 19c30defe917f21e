"""The smallest cam for a permitted pressure angle and a permitted curvature.

Seen from the guide of the follower, a lever's pivot or a rod, the roller's centre runs along a path q(psi), and the cam's
centre O is unknown. The contact normal has the direction of O - A, A = q + i q' (q' by the cam angle; q - i q' for a cam that
turns clockwise), and the pressure angle is that between it and the direction w in which the roller comes in. It is at most
alpha where O lies in the cone

    |Im((O - A) w*)| <= tan alpha Re((O - A) w*),

two half-planes, linear in O (cam-mathematics, "smallest cam", whose formula this is for a lever; for a rod it is
tan alpha = (e + s')/(D + s)). All cones together are a convex set K.

Swing. The cones of the two end positions, apart along the chord of the roller's path, open to different sides of the normal of
this chord where alpha < swing/2, and K is empty; where alpha is larger, all cones have a direction in common, and a centre far
away will do. So the pressure angle must be larger than half the lever's swing, and need not be more.

Base circle. On a lever O lies, for all cam angles, on that side of the line through pivot and roller to which the roller comes
in; so |O - q| falls as it does, and the least |O - q| of the cycle is that at the innermost position, the largest that at the
outermost. Either is the distance of O from a given point: the smallest cam is the nearest point of K, a convex problem in
two variables. Between the angles looked at K is enforced by exchange, as restrictions are in ``laws.synthesis``.

Curvature. That of the pitch curve is (|V|^2 -+ Im(V* A'))/|V|^3 with V = A - O. That it is at most 1/rho forbids O a bounded
region about each A: what remains is not convex, but never empty. There the plane is searched, on rays from the point in
question: each meets K in one piece, and beyond a known radius the curvature forbids nothing. What is found is refined by SLSQP,
with exchange. The search is as good as its rays: a better cam in a gap between forbidden regions that is narrower than they
are apart (a degree or two) could be missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from wucht.cams.cam import FlatFacedCam, RollerCam
from wucht.cams.followers import FlatFaced, OscillatingRoller, TranslatingRoller
from wucht.cams.laws.law import Law
from wucht.cams.laws.programs import InfeasibleError
from wucht.cams.undercut import GRID, STEP, TURN, narrowed, valleys
from wucht.errors import InputError, RunError
from wucht.numerics.zeros import RealFunction

Angles = float | tuple[float, float]
Size = Literal["base", "blank"]
_FIRST = np.arange(16) * (TURN / 16)
_EXACT = 1e-11  # of the size of the cam
_BETWEEN = 0.01  # of the largest value of a function: so much lower it may be between the angles of the grid
_MET = 1e-6  # rad, or of the curvature: a bound so near is reached
_MOST_EXCHANGES = 60
_LARGEST_ANGLE = math.radians(89)
_RAYS = np.concatenate([-np.geomspace(1e-5, math.pi, 160)[::-1], [0.0], np.geomspace(1e-5, math.pi, 160)])  # rad
_ALONG = np.linspace(0.0, 1.0, 80)  # of a ray
_HALVINGS = 20
_COARSE = GRID[::8]
_KEPT = 1e-7  # of 1: a programme is solved so well, or not at all
_MOST_STARTS = 4
_Pair = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class SmallestCam:
    """A cam with a roller, as small as it can be.

    follower: in the frame of ``followers``. base_radius, largest_radius: of the pitch curve in m; the contour's are less by the
    roller's radius. pressure_angle: the largest that is reached. binding: cam angles at which a permitted pressure angle is
    reached. least_radius: of curvature of the contour in m where it is convex, negative where it is undercut, infinite where
    it is nowhere convex; sharpest: the cam angle there. Angles in rad.
    """

    follower: OscillatingRoller | TranslatingRoller
    base_radius: float
    largest_radius: float
    pressure_angle: float
    binding: tuple[float, ...]
    least_radius: float
    sharpest: float


@dataclass(frozen=True)
class SmallestFlatFacedCam:
    """A cam with a flat face, as small as it can be.

    base_radius, largest_radius: of the contour in m. least_radius: of curvature in m; sharpest: the cam angle there in rad.
    face: between which distances from the rod's axis the face is touched, in m along +y.
    """

    follower: FlatFaced
    base_radius: float
    largest_radius: float
    least_radius: float
    sharpest: float
    face: tuple[float, float]


def smallest_lever_cam(
    law: Law, arm: float, roller_radius: float, pressure_angle: Angles, *, clockwise: bool = False, outward: bool = True,
    least_radius: float | None = None, smallest: Size = "base",
) -> SmallestCam:  # fmt: skip
    """The pivot's distance and the lever's angle that make the smallest cam for a lever.

    law: of the lever in rad. arm, roller_radius: in m. pressure_angle: the largest permitted one in rad, or two: for where the
    roller goes out, and for where it comes in. outward: the roller goes out as the law rises, else in. least_radius: the least
    permitted radius of curvature of the contour in m, where it is convex; 0 forbids undercut alone (that the roller cuts
    nothing elsewhere: ``undercut.check_roller``); None permits all. smallest: the base circle, or the largest radius ("blank").

    Raises ``InputError``: pressure_angle, with the least that is possible; law, where it does not move; least_radius, arm,
    roller_radius, where they are no lengths. ``RunError``: none was found, though there is one.
    """
    _positive("arm", arm)
    guide = OscillatingRoller(0.0, arm, roller_radius, 0.0)
    return _smallest(_Layout(law, guide, clockwise, -1 if outward else 1, _tangents(pressure_angle)), least_radius, smallest)


def smallest_rod_cam(
    law: Law, roller_radius: float, pressure_angle: Angles, *, clockwise: bool = False,
    least_radius: float | None = None, smallest: Size = "base",
) -> SmallestCam:  # fmt: skip
    """The distance and the offset that make the smallest cam for a rod; see ``smallest_lever_cam``. law: in m."""
    guide = TranslatingRoller(0.0, roller_radius)
    return _smallest(_Layout(law, guide, clockwise, -1, _tangents(pressure_angle)), least_radius, smallest)


def smallest_flat_faced_cam(
    law: Law, least_radius: float, *, clockwise: bool = False, shaft_radius: float = 0.0
) -> SmallestFlatFacedCam:
    """The least distance of a flat face. Its contour's radius of curvature is distance + psi + psi''.

    law: in m. least_radius: of curvature that is permitted, in m. shaft_radius: the least base circle, in m: a contour that is
    bent little enough need not even go round the shaft. Raises ``InputError`` (least_radius, shaft_radius).
    """
    for name, value in (("least_radius", least_radius), ("shaft_radius", shaft_radius)):
        _positive(name, value, or_zero=True)
    at, bends = valleys(lambda phi: law(phi) + law(phi, 2))
    k, lowest, highest = int(np.argmin(bends)), float(valleys(law)[1].min()), -float(valleys(lambda p: -law(p))[1].min())
    distance = max(least_radius - float(bends[k]), shaft_radius - lowest)
    cam = FlatFacedCam(law, FlatFaced(distance), clockwise)
    face = float(valleys(cam.contact)[1].min()), -float(valleys(lambda p: -cam.contact(p))[1].min())
    reached = distance + float(bends[k])
    return SmallestFlatFacedCam(cam.follower, distance + lowest, distance + highest, reached, float(at[k]), face)


def _positive(name: str, value: float, or_zero: bool = False) -> None:
    if not (math.isfinite(value) and (value > 0 or (or_zero and value == 0))):
        raise InputError(name, value, f"must be {'zero or ' if or_zero else ''}greater than zero (in m)")


def _tangents(permitted: Angles) -> tuple[float, float]:
    both = permitted if isinstance(permitted, tuple) else (permitted, permitted)
    for angle in both:
        if not 0 < angle <= _LARGEST_ANGLE:
            raise InputError("pressure_angle", angle, "must be greater than zero and at most 89 deg (in rad)")
    return math.tan(both[0]), math.tan(both[1])


@dataclass(frozen=True, eq=False)
class _Layout:
    """guide: the follower with its pivot or rod in the origin. inward: the sense of the law in which the roller comes in.
    tangents: of the pressure angles that are permitted as it goes out and as it comes in."""

    law: Law
    guide: OscillatingRoller | TranslatingRoller
    clockwise: bool
    inward: int
    tangents: tuple[float, float]

    @property
    def turn(self) -> complex:
        return -1j if self.clockwise else 1j

    def cones(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Apex A, axis w and tangent of the half angle (N,)."""
        rate = self.guide.rate(self.law(phi))
        out = -self.inward * self.law(phi, 1)
        away, back = self.tangents
        tangent = np.where(out > 0, away, np.where(out < 0, back, min(away, back)))
        apex = self.guide.centre(self.law, phi) + self.turn * self.guide.centre(self.law, phi, 1)
        return apex, self.inward * rate / np.abs(rate), tangent

    @cached_property
    def on_grid(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.cones(GRID)

    @cached_property
    def size(self) -> float:
        return float(np.abs(self.on_grid[0]).max())

    @cached_property
    def range(self) -> tuple[float, float]:
        """The least and the greatest value of the law."""
        low, high = float(valleys(self.law)[1].min()), -float(valleys(lambda p: -self.law(p))[1].min())
        if not high > low:
            raise InputError("law", None, "it does not move: there is no pressure angle to size a cam by")
        return low, high

    @property
    def ends(self) -> tuple[complex, complex]:
        """The roller's centre at the innermost and the outermost position."""
        inner, outer = self.guide.place(np.array(self.range[::-1] if self.inward > 0 else self.range))
        return complex(inner), complex(outer)

    @property
    def swing(self) -> float:
        """By how much the axes of the cones turn, in rad."""
        return self.range[1] - self.range[0] if isinstance(self.guide, OscillatingRoller) else 0.0

    def half_planes(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Normals a and bounds b (2 N,): Re(O a*) <= b, the normals of modulus 1."""
        apex, axis, tangent = self.cones(phi)
        a = np.concatenate([(1j - tangent) * axis, (-1j - tangent) * axis]) / np.tile(np.hypot(1, tangent), 2)
        return a, (np.tile(apex, 2) * a.conj()).real

    def broken(self, centre: complex) -> np.ndarray:
        """The cam angles at which O lies farthest outside of the cones, of those where it does."""

        def inside(cones: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
            apex, axis, tangent = cones
            off = (centre - apex) * axis.conj()
            return np.asarray((tangent * off.real - np.abs(off.imag)) / np.hypot(1, tangent))

        return _farthest(inside(self.on_grid), lambda phi: inside(self.cones(phi)), -_EXACT * max(self.size, abs(centre)))

    def bends(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A and A'/(+-i) (N,), on which the curvature depends."""
        first, second = (self.guide.centre(self.law, phi, order) for order in (1, 2))
        return self.guide.centre(self.law, phi) + self.turn * first, first / self.turn + second


def _curvature(v: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """Of the pitch curve in 1/m, of V = A - O and A'/(+-i)."""
    return np.asarray((np.abs(v) ** 2 - (v.conj() * turned).real) / np.abs(v) ** 3)


def _curvature_slope(v: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """Its gradient by O, as complex numbers."""
    return np.asarray((turned - 2 * v) / np.abs(v) ** 3 + 3 * _curvature(v, turned) * v / np.abs(v) ** 2)


def _farthest(values: np.ndarray, function: RealFunction, bound: float) -> np.ndarray:
    """The minima of a function below a bound, whose values on the grid are known: between its angles they may be lower."""
    near = values < bound + _BETWEEN * np.abs(values).max()
    i = np.flatnonzero((values < np.roll(values, 1)) & (values <= np.roll(values, -1)) & near)
    if not len(i):
        return np.zeros(0)
    at = narrowed(function, GRID[i] - STEP, GRID[i] + STEP)
    return np.asarray(at[function(at) < bound])


def _smallest(layout: _Layout, least_radius: float | None, smallest: Size) -> SmallestCam:
    _positive("roller_radius", layout.guide.roller_radius, or_zero=True)
    target = layout.ends[0 if smallest == "base" else 1]
    try:
        centre, phi = _nearest_in_cones(layout, target)
    except InfeasibleError:
        swing, permitted = layout.swing, math.atan(min(layout.tangents))
        allowed = f"no cam has it: it must be greater than {math.degrees(swing) / 2:.6g} deg, half the lever's swing"
        raise InputError("pressure_angle", f"{math.degrees(permitted):.6g} deg", allowed) from None
    if least_radius is not None:
        _positive("least_radius", least_radius, or_zero=layout.guide.roller_radius > 0)
        centre = _with_curvature(layout, target, centre, phi, 1 / (layout.guide.roller_radius + least_radius))
    return _described(layout, centre)


def _nearest_in_cones(layout: _Layout, target: complex) -> tuple[complex, np.ndarray]:
    """The point of K that is nearest to a target, and the angles of the cones that were looked at."""
    phi = _FIRST
    if math.atan(min(layout.tangents)) <= layout.swing / 2:
        raise InfeasibleError
    for _ in range(_MOST_EXCHANGES):
        centre = _nearest(target, *layout.half_planes(phi), layout.size)
        broken = layout.broken(centre)
        if not len(broken):
            return centre, phi
        phi = np.append(phi, broken)
    raise RunError(f"the cam's size is still not found after {_MOST_EXCHANGES} exchanges: its law may jump")


def _nearest(target: complex, a: np.ndarray, b: np.ndarray, size: float) -> complex:
    """The point with Re(O a*) <= b (m,) nearest to a target: that itself, its foot on a line, or where two lines meet."""
    beyond = (target * a.conj()).real - b
    i, j = np.triu_indices(len(a), 1)
    area = (a[i].conj() * a[j]).imag
    meet = np.divide(1j * (b[j] * a[i] - b[i] * a[j]), area, out=np.full(len(i), np.nan + 0j), where=np.abs(area) > _EXACT)
    tried = np.concatenate([[target], target - beyond * a, meet])
    tried = tried[np.argsort(np.abs(tried - target))]
    for part in np.array_split(tried, max(1, len(tried) // 128)):
        beyond = (np.multiply.outer(part, a.conj()).real - b).max(axis=1)
        kept = np.flatnonzero(beyond <= _EXACT / 10 * np.maximum(size, np.abs(part)))
        if len(kept):
            return complex(part[kept[0]])
    raise InfeasibleError


def _with_curvature(layout: _Layout, target: complex, centre: complex, phi: np.ndarray, most: float) -> complex:
    """The point of K nearest to a target where the pitch curve is nowhere bent more sharply; ``centre``: of K alone."""
    if not len(_sharper(layout, centre, most)):
        return centre
    found = [_refined(layout, target, start, phi, most) for start in _starts(layout, target, centre, most)]
    kept = [z for z in found if z is not None]
    if not kept:
        raise RunError("no cam of that least radius was found: permit a smaller one, or a larger pressure angle")
    return min(kept, key=lambda z: abs(z - target))


def _sharper(layout: _Layout, centre: complex, most: float) -> np.ndarray:
    def room(phi: np.ndarray) -> np.ndarray:
        apex, turned = layout.bends(phi)
        return np.asarray(1 - _curvature(apex - centre, turned) / most)

    return _farthest(room(GRID), room, -100 * _EXACT)


def _starts(layout: _Layout, target: complex, centre: complex, most: float) -> list[complex]:
    """On each ray from the target the first point that will do; of these the nearest ones of their surroundings."""
    (apex, turned), (a, b) = layout.bends(_COARSE), layout.half_planes(_COARSE)
    # |V|^2 + |V||A'| <= |V|^3/rho, and nothing is forbidden: |V| beyond the positive root.
    free = float(np.abs(target - apex).max() + (1 + math.sqrt(1 + 4 * most * np.abs(turned).max())) / (2 * most))
    middle = layout.inward * layout.guide.rate(np.array(sum(layout.range) / 2))
    rays = np.exp(1j * (np.angle(centre - target) + _RAYS))
    rays = np.append(rays, middle / abs(middle))  # to where all cones open
    first = np.full(len(rays) + 2, np.inf)
    for k, ray in enumerate(rays):
        slope, room = (ray * a.conj()).real, b - (target * a.conj()).real
        enter = float(np.max(room[slope < 0] / slope[slope < 0], initial=0.0))
        leave = float(np.min(room[slope > 0] / slope[slope > 0], initial=max(enter, free)))
        if enter <= leave * (1 + _MET):

            def will_do(at: float, ray: complex = ray) -> bool:
                return bool(_curvature(apex - (target + at * ray), turned).max() <= most)

            first[k + 1] = _first_on(will_do, enter, leave)
    nearest = np.flatnonzero(np.isfinite(first[1:-1]) & (first[1:-1] <= first[2:]) & (first[1:-1] <= first[:-2]))
    nearest = nearest[np.argsort(first[1:-1][nearest])][:_MOST_STARTS]
    return [complex(target + first[k + 1] * rays[k]) for k in nearest]


def _first_on(holds: Callable[[float], bool], begin: float, end: float) -> float:
    """The first of many points between two where a condition holds, and from the one before on more exactly; infinity: none."""
    at = begin + (end - begin) * _ALONG
    k = next((k for k, x in enumerate(at) if holds(x)), None)
    if k is None or k == 0:
        return math.inf if k is None else begin
    low, high = float(at[k - 1]), float(at[k])
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def _refined(layout: _Layout, target: complex, start: complex, phi: np.ndarray, most: float) -> complex | None:
    """The nearest point that will do about a start, None where none is found."""
    size, sharp, z = layout.size, GRID[::256], start
    for _ in range(_MOST_EXCHANGES):
        found = _nearest_about(z, target, size, layout.half_planes(phi), layout.bends(sharp), most)
        if found is None:
            return None
        z = found
        broken, sharper = layout.broken(z), _sharper(layout, z, most)
        if not len(broken) + len(sharper):
            return z
        phi, sharp = np.append(phi, broken), np.append(sharp, sharper)
    return None


def _nearest_about(start: complex, target: complex, size: float, planes: _Pair, bends: _Pair, most: float) -> complex | None:
    """The nearest point to a target, about a start, with so many half-planes and curvatures; in x = (O - target)/size."""
    from scipy.optimize import minimize

    (a, b), (apex, turned) = planes, bends

    def room(x: np.ndarray) -> np.ndarray:
        z = target + size * complex(*x)
        return np.concatenate([(b - (z * a.conj()).real) / size, 1 - _curvature(apex - z, turned) / most])

    def slope(x: np.ndarray) -> np.ndarray:
        rows = np.concatenate([-a, -size / most * _curvature_slope(apex - (target + size * complex(*x)), turned)])
        return np.column_stack([rows.real, rows.imag])

    away = (start - target) / size
    found = minimize(
        lambda x: x @ x, [away.real, away.imag], jac=lambda x: 2 * x, method="SLSQP",
        constraints={"type": "ineq", "fun": room, "jac": slope}, options={"ftol": 1e-14, "maxiter": 100},
    )  # fmt: skip
    return complex(target + size * complex(*found.x)) if room(found.x).min() > -_KEPT else None


def _described(layout: _Layout, centre: complex) -> SmallestCam:
    """The cam whose centre is O, turned and moved so that O is 0 and the pivot on +x, or the rod along +x."""
    guide = layout.guide
    follower: OscillatingRoller | TranslatingRoller
    if isinstance(guide, OscillatingRoller):
        angle = math.remainder(math.pi - float(np.angle(centre)), TURN)
        follower = replace(guide, pivot=abs(centre), angle=angle)
    else:
        follower = replace(guide, distance=-centre.real, offset=-centre.imag)
    cam = RollerCam(layout.law, follower, layout.clockwise)

    def spare(phi: np.ndarray) -> np.ndarray:
        return np.asarray(np.arctan(layout.cones(phi)[2]) - np.abs(cam.pressure_angle(phi)))

    at, spares = valleys(spare)
    largest = -float(valleys(lambda phi: -np.abs(cam.pressure_angle(phi)))[1].min())
    sharpest, bends = valleys(lambda phi: -cam.pitch_curvature(phi))
    k = int(np.argmin(bends))
    radius = -1 / float(bends[k]) - guide.roller_radius if bends[k] < 0 else math.inf
    near, far = (abs(end - centre) for end in layout.ends)
    binding = tuple(float(x) for x in np.sort(at[spares < _MET]))
    return SmallestCam(follower, near, far, largest, binding, radius, float(sharpest[k]))
