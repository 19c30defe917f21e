"""Findings -> the Dataset of a motion law."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.cams.laws.synthesis import Band
from wucht.results.conventions import answered, variable
from wucht.studies.cam_law.prepare import Plan
from wucht.studies.cam_law.run import Findings

if TYPE_CHECKING:
    import xarray as xr

NAMES = ("position", "velocity", "acceleration", "jerk")


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a motion law.

    Coordinates: cam_angle (N), order (K, from 1), restriction (R). position, velocity, acceleration, jerk (cam_angle): the
    motion and its derivatives by the cam angle. mean, cosine, sine, amplitude (order). Of each restriction: restricted (0 to 3,
    -1 for a cap of a harmonic), harmonic, begin, end, low, high, least, greatest.
    """
    import xarray as xr_

    f, unit, asked = findings, plan.motion.unit, plan.motion.restrictions
    bands = [r if isinstance(r, Band) else Band(r.name, -1, math.nan, math.nan, 0.0, r.size) for r in asked]
    by_angle = [unit, f"{unit}/rad", f"{unit}/rad^2", f"{unit}/rad^3"]
    called = ["motion of the output", *(f"{name} by the cam angle" for name in NAMES[1:])]
    data = {
        **{n: variable("cam_angle", d, c, u) for n, d, c, u in zip(NAMES, f.derivatives, called, by_angle, strict=True)},
        "mean": variable("", f.harmonics.mean, "mean of the motion", unit),
        "cosine": variable("order", f.harmonics.cosine, "cosine coefficient", unit),
        "sine": variable("order", f.harmonics.sine, "sine coefficient", unit),
        "amplitude": variable("order", f.harmonics.amplitudes, "amplitude", unit),
        "restricted": variable("restriction", [b.order for b in bands], "derivative that is restricted"),
        "harmonic": variable(
            "restriction", [0 if isinstance(r, Band) else r.harmonic for r in asked], "harmonic that is capped"
        ),
        "begin": variable("restriction", [b.begin for b in bands], "begin of the arc", "rad"),
        "end": variable("restriction", [b.end for b in bands], "end of the arc", "rad"),
        "low": variable("restriction", [b.low for b in bands], "least value allowed"),
        "high": variable("restriction", [b.high for b in bands], "greatest value allowed"),
        "least": variable("restriction", f.met[:, 0], "least value"),
        "greatest": variable("restriction", f.met[:, 1], "greatest value"),
    }
    coordinates = {
        "cam_angle": variable("cam_angle", f.angles, "cam angle", "rad"),
        "order": variable("order", np.arange(1, f.harmonics.count + 1), "order"),
        "restriction": variable("restriction", [r.name for r in asked], "restriction"),
    }
    summary = _summary(plan, findings)
    return answered(xr_.Dataset(dict(data), coords=coordinates), summary, summary["sentence"], _warnings(summary))


def _warnings(summary: dict[str, Any]) -> list[str]:
    """A jump of the acceleration is a shock."""
    if not summary["acceleration_jumps"]:
        return []
    ends = "the acceleration jumps where the rise and the return begin or end, and the jerk has no bound there"
    return [f"{ends}: for slow shafts alone; a polynomial or a sine law does not jump"]


def _ripple(plan: Plan, f: Findings) -> float | None:
    """The largest deviation from what is asked on the arcs that are to be as tight as they can be, or else in the dwells."""
    asked = plan.motion.restrictions
    kept = {r.name for r in asked if r.widened} or {band.name for band in plan.motion.dwells}
    found = zip(asked, f.met, strict=True)
    off = [np.abs(met - (r.low + r.high) / 2).max() for r, met in found if isinstance(r, Band) and r.name in kept]
    return float(max(off)) if off else None


def _summary(plan: Plan, f: Findings) -> dict[str, Any]:
    summary: dict[str, Any] = {
        "sentence": "",
        "unit": plan.motion.unit,
        "stroke": f.greatest - f.least,
        "harmonics": plan.motion.count,
        "ripple": _ripple(plan, f),
        "peaks": dict(zip(NAMES, f.peaks.tolist(), strict=True)),
        "acceleration_jumps": f.jump,
        "rise": None if f.rise is None else dict(zip(NAMES[1:], f.rise.tolist(), strict=True)),
        "coefficients": {
            "mean": f.harmonics.mean,
            "cosine": f.harmonics.cosine.tolist(),
            "sine": f.harmonics.sine.tolist(),
        },
    }
    count = plan.motion.count
    made = "a motion by its points or pieces" if count is None else f"a motion of {count} harmonic{'s' if count > 1 else ''}"
    restricted = len(plan.motion.restrictions)
    summary["sentence"] = made + (f" meets {restricted} restriction{'s' if restricted > 1 else ''}" if restricted else "")
    return summary
