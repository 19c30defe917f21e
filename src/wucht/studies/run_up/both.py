"""Both models in one Dataset, and how far they are apart."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wucht.results.conventions import summary_of, variable
from wucht.results.store import to_json
from wucht.studies.deviations import Course, Deviations, at_equal_angle, at_equal_phase, watched
from wucht.studies.observables import Orbit
from wucht.studies.run_up.run import Motion

if TYPE_CHECKING:
    import xarray as xr

_SHOWN = ("angle", "speed", "amplitude", "phase", "rotor_phase", "radius")


def joined(motions: Sequence[Motion], runs: Sequence[xr.Dataset]) -> xr.Dataset:
    """The Dataset of the full run-up with the averaged one at the same times; of one model alone as it is. motions: theirs.

    Variables slow_angle, slow_speed (body, time), slow_phase (balancer, time), slow_amplitude, slow_radius (time);
    speed_deviation and radius_deviation (compared), at equal angle of the rotor. Summary: ``slow`` and ``deviations``.
    """
    if len(runs) == 1:
        return runs[0]
    found, slow = runs
    if slow.attrs["failure"]:
        warnings = [*json.loads(found.attrs["warnings"]), f"slow equations: {slow.attrs['failure']}"]
        found.attrs["warnings"] = to_json(warnings, indent=None)
    sampled = slow.sizes["time"]
    for name in (n for n in _SHOWN if n in slow):
        values = np.full((*slow[name].shape[:-1], found.sizes["time"]), np.nan)
        values[..., :sampled] = slow[name].values
        attributes = found[name].attrs
        found[f"slow_{name}"] = variable(
            " ".join(map(str, found[name].dims)), values, f"{attributes['long_name']}, slow equations", attributes["units"]
        )
    full, averaged = map(course_of, motions)
    by_angle, by_phase = at_equal_angle(full, averaged), at_equal_phase(full, averaged)
    found = _with_deviations(found, by_angle)
    both = summary_of(found) | {
        "slow": summary_of(slow),
        "deviations": {"at_equal_angle": _largest(by_angle), "at_equal_phase": _largest(by_phase)},
    }
    found.attrs |= {"summary": to_json(both, indent=None), "model": "both"}
    return found


def course_of(motion: Motion) -> Course:
    """What is compared of a motion."""
    machine, rows = motion.case.machine, motion.rows
    about = [b for b in machine.bodies if b.about == machine.rotor.name]
    angle = rows[machine.rotor.coordinate.position.name]
    speed = np.array([rows[b.coordinate.velocity.name] for b in watched(machine)])
    sense = float(np.sign(angle[-1] - angle[0])) or 1.0
    mean = np.mean([rows[b.coordinate.position.name] for b in about], axis=0) if about else None
    radius = Orbit.of(machine, motion.seen.time, rows).distance
    return Course(sense * angle, sense * speed, radius, None if mean is None else sense * (mean - angle))


def _largest(found: Deviations | None) -> dict[str, float] | None:
    return None if found is None else dict(zip(("speed", "amplitude"), found.largest, strict=True))


def _with_deviations(result: xr.Dataset, found: Deviations | None) -> xr.Dataset:
    if found is None:
        return result
    name = "angle of the rotor at which the models are compared"
    return result.assign_coords(compared=variable("compared", found.at, name, "rad")).assign(
        speed_deviation=variable("compared", found.speed, "speed, full less slow", result.speed.attrs["units"]),
        radius_deviation=variable(
            "compared", found.radius, "distance of the axis, full less slow", result.radius.attrs["units"]
        ),
    )
