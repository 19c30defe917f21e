"""Findings -> the Dataset of a motion law."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from wucht.cams.laws.synthesis import Band
from wucht.results.quantities import Quantity, answer
from wucht.studies.cam_law.prepare import Plan
from wucht.studies.cam_law.run import Findings

if TYPE_CHECKING:
    import xarray as xr

NAMES = ("position", "velocity", "acceleration", "jerk")


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a motion law."""
    quantities = [*_of_motion(plan, findings), *_of_restrictions(plan, findings), *_of_whole(plan, findings)]
    return answer(quantities, _sentence(plan), _warnings(findings))


def _of_motion(plan: Plan, f: Findings) -> list[Quantity]:
    """The motion and its derivatives over the cam angle, and its harmonics."""
    unit = plan.motion.unit
    called = ["motion of the output", *(f"{name} by the cam angle" for name in NAMES[1:])]
    derivatives = zip(NAMES, f.derivatives, called, _units(plan), strict=True)
    return [
        Quantity("cam_angle", f.angles, "cam angle", "rad", "cam_angle"),
        *(Quantity(name, values, what, per, "cam_angle") for name, values, what, per in derivatives),
        Quantity("mean", f.harmonics.mean, "mean of the motion", unit, ""),
        Quantity("order", np.arange(1, f.harmonics.count + 1), "order", "", "order"),
        Quantity("cosine", f.harmonics.cosine, "cosine coefficient", unit, "order"),
        Quantity("sine", f.harmonics.sine, "sine coefficient", unit, "order"),
        Quantity("amplitude", f.harmonics.amplitudes, "amplitude", unit, "order"),
    ]


def _units(plan: Plan) -> list[str]:
    """Of the motion and its derivatives by the cam angle."""
    return [f"{plan.motion.unit}{per}" for per in ("", "/rad", "/rad^2", "/rad^3")]


def _of_restrictions(plan: Plan, f: Findings) -> list[Quantity]:
    """What was asked, on which arc, and what the motion has there."""
    restrictions = plan.motion.restrictions
    bands = [r if isinstance(r, Band) else Band(r.name, -1, math.nan, math.nan, 0.0, r.size) for r in restrictions]
    harmonics = [0 if isinstance(r, Band) else r.harmonic for r in restrictions]
    along = "restriction"
    return [
        Quantity("restriction", [r.name for r in restrictions], "restriction", "", along),
        Quantity("restricted", [b.order for b in bands], "derivative that is restricted, -1: a harmonic is capped", "", along),
        Quantity("harmonic", harmonics, "harmonic that is capped", "", along),
        Quantity("begin", [b.begin for b in bands], "begin of the arc", "rad", along),
        Quantity("end", [b.end for b in bands], "end of the arc", "rad", along),
        Quantity("low", [b.low for b in bands], "least value allowed", "", along),
        Quantity("high", [b.high for b in bands], "greatest value allowed", "", along),
        Quantity("least", f.met[:, 0], "least value", "", along),
        Quantity("greatest", f.met[:, 1], "greatest value", "", along),
    ]


def _of_whole(plan: Plan, f: Findings) -> list[Quantity]:
    """What the summary has beside it."""
    unit, units, harmonics = plan.motion.unit, _units(plan), f.harmonics
    peaks = {name: (f"largest {name}", per) for name, per in zip(NAMES, units, strict=True)}
    rise = None if f.rise is None else dict(zip(NAMES[1:], f.rise.tolist(), strict=True))
    coefficients = {"mean": harmonics.mean, "cosine": harmonics.cosine.tolist(), "sine": harmonics.sine.tolist()}
    return [
        Quantity("unit", unit, "unit of the motion"),
        Quantity("stroke", f.greatest - f.least, "stroke", unit),
        Quantity("harmonics", plan.motion.count, "number of harmonics"),
        Quantity("ripple", _ripple(plan, f), "largest deviation from what is asked in dwells", unit, headline=True),
        Quantity("peaks", dict(zip(NAMES, f.peaks.tolist(), strict=True)), "largest values", parts=peaks, headline=NAMES[1:]),
        Quantity("acceleration_jumps", f.jump, "largest jump of the acceleration", units[2]),
        Quantity("rise", rise, "largest values of a rise of 1 over an arc of 1"),
        Quantity("coefficients", coefficients, "coefficients of the harmonics", unit),
    ]


def _warnings(f: Findings) -> list[str]:
    """A jump of the acceleration is a shock."""
    if not f.jump:
        return []
    ends = "the acceleration jumps where the rise and the return begin or end, and the jerk has no bound there"
    return [f"{ends}: for slow shafts alone; a polynomial or a sine law does not jump"]


def _ripple(plan: Plan, f: Findings) -> float | None:
    """The largest deviation from what is asked on the arcs that are to be as tight as they can be, or else in the dwells."""
    restrictions = plan.motion.restrictions
    kept = {r.name for r in restrictions if r.widened} or {band.name for band in plan.motion.dwells}
    pairs = zip(restrictions, f.met, strict=True)
    off = [np.abs(met - (r.low + r.high) / 2).max() for r, met in pairs if isinstance(r, Band) and r.name in kept]
    return float(max(off)) if off else None


def _sentence(plan: Plan) -> str:
    count, restricted = plan.motion.count, len(plan.motion.restrictions)
    made = "a motion by its points or pieces" if count is None else f"a motion of {count} harmonic{'s' if count > 1 else ''}"
    return made + (f" meets {restricted} restriction{'s' if restricted > 1 else ''}" if restricted else "")
