"""A flat face on an eccentric circle, and a roller on a rod, in closed form: sizes, limits on both sides, contact, arcs, lines.

The face moves by -a cos phi about d: the cam is a circle of radius d about a point at the distance a. The centre of a roller
on a rod that moves so is seen at the pressure angle asin(a/d) at most.
"""

from __future__ import annotations

import math
from typing import Any

import cam_files_to_study as given
import numpy as np
import pytest
import xarray as xr

from wucht import CamContour, run

pytestmark = pytest.mark.usefixtures("coarse_angles")

A, D, MASS, SPEED, WIDTH = 0.010, 0.040, 0.4, 20.0, 0.015
INERTIA_FORCE = MASS * SPEED**2 * A  # 1.6 N
COMPLIANCE = 2 * (1 - 0.3**2) / 210e9
DEG = math.pi / 180


def cam(follower: dict[str, Any], cosine: list[float], **asked: Any) -> xr.Dataset:
    law = {"kind": "harmonic", "coefficients": {"mean": "0 mm", "cosine": [f"{1e3 * x} mm" for x in cosine]}}
    return run(CamContour(**{"points": 16, "chord_tolerance": "50 um"} | asked), given.drive(law, follower))


def face(preload: float | None = None, **asked: Any) -> xr.Dataset:
    """The circle, with contact where a preload in N is given."""
    if preload is not None:
        asked |= {"contact": {"mass": MASS, "preload": preload, "width": WIDTH}, "speed": SPEED}
    return cam(given.FLAT, [-A], **asked)


def rod(pressure_angle: float, **asked: Any) -> xr.Dataset:
    """A roller whose pressure angle is at most this one, in degrees."""
    return cam(
        given.ROD | {"offset": 0.0, "distance": A / math.sin(pressure_angle * DEG), "roller_radius": "2 mm"}, [-A], **asked
    )


def test_the_largest_of_the_contact_is_not_that_of_the_angles_that_are_shown() -> None:
    """Whose 16 miss the largest torque; the torque's size counts."""
    result, phi = face(4.0), np.linspace(0.0, math.pi, 20_001)
    torque = (4 + INERTIA_FORCE * np.cos(phi)) * A * np.sin(phi)
    contact = result.wucht.summary["contact"]
    assert contact["max_torque"]["value"] == pytest.approx(torque.max(), rel=1e-4)
    assert contact["max_torque"]["at"] == pytest.approx(phi[torque.argmax()], abs=0.013)
    assert np.abs(result.camshaft_torque.values).max() < 0.998 * torque.max()
    assert contact["max_force"]["cam"] == {"value": pytest.approx(4 + INERTIA_FORCE), "at": 0.0}
    assert (contact["mean_speed"], contact["least_preload"]) == (SPEED, pytest.approx(INERTIA_FORCE))
    units = [result.wucht.unit_at(f"contact.{key}") for key in ("least_preload", "max_torque", "max_pressure.cam.value")]
    assert units == ["N", "N m", "Pa"]


@pytest.mark.parametrize(("key", "limit", "beyond", "clause"), [
    ("least_radius", D, 1.001, "least radius 40 mm (permitted 40.04 mm)"),
    ("shaft_radius", D - A, 1.001, "base circle 30 mm (permitted 30.03 mm, that of the shaft)"),
    ("contact_pressure", math.sqrt((60 + INERTIA_FORCE) / (math.pi * WIDTH) / D / COMPLIANCE), 0.999, "contact pressure 61."),
    ("pressure_angle", 20 * DEG, 0.999, "pressure angle 20° at 70° (permitted 19.98°)"),
])  # fmt: skip
def test_limits_on_both_sides(key: str, limit: float, beyond: float, clause: str) -> None:
    """A limit that is just reached, up to rounding, is kept."""
    kept, broken = (
        (rod(20.0, permitted={key: size}) if key == "pressure_angle" else face(60.0, permitted={key: size})).wucht.summary
        for size in (limit * (1 + 1e-7 if beyond < 1 else 1 - 1e-7), limit * beyond)
    )
    assert kept["outcome"] == "cuttable" and "permitted" not in kept["sentence"]
    assert broken["outcome"] == "not-permitted"
    assert broken["sentence"].startswith(f"cuttable, but outside the permitted limits: {clause}")


def test_a_large_pressure_angle_is_told_where_none_is_permitted() -> None:
    [told] = rod(30.01).wucht.warnings
    assert told.startswith("the pressure angle reaches 30.01° at a cam angle of 59.99°; with a rod, at most 30° is common")
    assert rod(29.99).wucht.warnings == []
    assert rod(30.01, permitted={"pressure_angle": "50 deg"}).wucht.warnings == []
    assert told in rod(30.01, permitted={"least_radius": "1 mm"}).wucht.warnings


def test_where_the_face_lifts_off() -> None:
    """By its preload of half the force that would be needed: from 120 to 240 degrees."""
    result = face(INERTIA_FORCE / 2)
    s, clause = result.wucht.summary, "the face lifts off from 120° to 240° (a preload of 1.6 N holds it)"
    assert s["outcome"] == "lifts-off" and s["sentence"].endswith(f"; {clause}") and s["sentence"].startswith("cuttable: ")
    [arc] = s["contact"]["lift_off"]["cam"]
    assert arc == pytest.approx([120 * DEG, 240 * DEG])
    arcs = [result[f"arc_{name}"].values.tolist() for name in ("cam", "of", "begin", "end")]
    assert arcs == [["cam"], ["lift-off"], [arc[0]], [arc[1]]]
    limited = face(INERTIA_FORCE / 2, permitted={"least_radius": "41 mm", "shaft_radius": "31 mm"}).wucht.summary
    assert (limited["outcome"], limited["sentence"]) == ("not-permitted", (
        "cuttable, but outside the permitted limits: least radius 40 mm (permitted 41 mm), base circle 30 mm (permitted 31 mm, "
        f"that of the shaft); {clause}"
    ))  # fmt: skip


def test_five_lobes_are_cut_away_on_more_than_they_run_backwards() -> None:
    """The radius 40 + 48 cos 5 phi (mm) is negative on five arcs; each of them is within one that is missing."""
    result = cam(given.FLAT, [0, 0, 0, 0, -0.002], allow_undercut=True)
    s, half = result.wucht.summary, (math.pi - math.acos(-40 / 48)) / 5
    shape, middles = s["cams"]["cam"], [(2 * k + 1) * math.pi / 5 for k in range(5)]
    assert np.ravel(shape["undercut"]) == pytest.approx([m + sign * half for m in middles for sign in (-1, 1)], abs=1e-3)
    missing = np.reshape(shape["missing"], (5, 2))
    assert (missing[:, 0] < np.array(middles) - 1.05 * half).all() and missing.mean(axis=1) == pytest.approx(middles, abs=1e-3)
    texts = [f"from {a / DEG:.4g}° to {b / DEG:.4g}°" for a, b in missing[:3]]
    assert (s["outcome"], s["undercut"], shape["points_to_mill"]) == ("undercut", True, 0)
    assert s["sentence"] == f"undercut: the face cuts the cam away {' and '.join(texts)} and on 2 more arcs"
    assert result.arc_of.values.tolist() == ["undercut"] * 5 + ["missing"] * 5
    assert result.arc_begin.values[5:] == pytest.approx(missing[:, 0]) and result.arc_end.values[5:] == pytest.approx(
        missing[:, 1]
    )
