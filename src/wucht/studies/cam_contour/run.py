"""Plan -> findings: the contours over the cam angle, the points to mill, and what presses on them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.laws.law import Law
from wucht.cams.workshop.cam_files import Outline
from wucht.cams.workshop.points import PointList, chord_points
from wucht.cams.workshop.rounding import rounding_warning
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.studies.cam_contour.contact_load import Pressed, largest_pressed, pressed
from wucht.studies.cam_contour.prepare import Plan


@dataclass(frozen=True, eq=False)
class Curves:
    """Of a cam over cam angles (N,): contour, pitch (None of a flat face), normal: complex, in m; curvature in 1/m, positive
    where the material bulges; left: 1 - (what the roller takes), see ``Cam.undercut``; pressure_angle in rad."""

    contour: np.ndarray
    pitch: np.ndarray | None
    normal: np.ndarray
    curvature: np.ndarray
    left: np.ndarray
    pressure_angle: np.ndarray


@dataclass(frozen=True, eq=False)
class Findings:
    """angles (N,) in rad. output, lever (3, N): the motions and their first derivatives by the cam angle. transmission (N,): of
    the linkage in rad, or None. to_mill: points of each cam, none where some is cut away. pressed: over the angles; largest:
    densely, for the largest values. notes: warnings."""

    angles: np.ndarray
    output: np.ndarray
    lever: np.ndarray
    transmission: np.ndarray | None
    curves: Mapping[str, Curves]
    to_mill: Mapping[str, PointList]
    pressed: Pressed | None
    largest: Pressed | None
    notes: tuple[str, ...]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """All at once: it takes a second."""
    work.report(0.0, "contours")
    angles = np.linspace(0, 2 * np.pi, plan.spec.points + 1)
    curves = {name: _curves(cam, angles) for name, cam in plan.cams.items()}
    work.report(0.3, "points to mill")
    to_mill, notes = _to_mill(plan)
    work.report(0.8, "contact")
    over_turn = largest = None
    if plan.contact is not None and plan.whole:
        over_turn, largest = pressed(plan.contact, plan.cams, angles), largest_pressed(plan.contact, plan.cams)
    elif plan.contact is not None:
        notes.append("no contact forces: some of the contour is cut away, and the follower does not move by its law")
    closure = plan.drive.closure
    transmission = None if closure is None else closure.transmission_angle(plan.lever(angles))
    output, lever = _derivatives(plan.output, angles), _derivatives(plan.lever, angles)
    yield Findings(angles, output, lever, transmission, curves, to_mill, over_turn, largest, (*plan.notes, *notes))


def _derivatives(law: Law, angles: np.ndarray) -> np.ndarray:
    return np.array([law(angles, order) for order in range(3)])


def _curves(cam: Cam, angles: np.ndarray) -> Curves:
    pitch = None if cam.pitch_curve is None else cam.pitch_curve(angles, 0)
    curvature = cam.material * cam.curvature(angles)
    return Curves(cam.contour(angles), pitch, cam.normal(angles), curvature, cam.undercut(angles), cam.pressure_angle(angles))


def _to_mill(plan: Plan) -> tuple[dict[str, PointList], list[str]]:
    """The points of each cam, and warnings about their rounding. Raises ``InputError`` (study.chord_tolerance)."""
    if not plan.whole:
        return {}, ["no points to mill: some of the contour is cut away"]
    spec, points, notes = plan.spec, dict[str, PointList](), list[str]()
    for name, cam in plan.cams.items():
        contour = Outline(cam.contour)
        try:
            points[name] = chord_points(contour, spec.chord_tolerance, spec.spacing)
        except InputError as error:
            where = f"study.{'chord_tolerance' if error.where == 'tolerance' else error.where}"
            raise InputError(where, error.given, error.allowed) from None
        coarse = rounding_warning(contour, points[name], 1e-3 * 10.0**-spec.decimals)
        notes += [f"{name}: {coarse}"] if coarse else []
    return points, notes
