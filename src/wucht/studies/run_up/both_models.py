"""Both models in one Dataset, and how far they are apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from wucht.dynamics.run_ups.deviations import at_equal_angle, at_equal_phase, course_of
from wucht.dynamics.run_ups.run_up import Motion
from wucht.results.conventions import variable
from wucht.results.store import to_json

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
    full, slow = runs
    if slow.attrs["failure"]:
        warnings = [*full.wucht.warnings, f"averaged equations: {slow.attrs['failure']}"]
        full = full.assign_attrs(warnings=to_json(warnings, indent=None))
    later = full.sizes["time"] - slow.sizes["time"]
    for name in (n for n in _SHOWN if n in slow):
        values, of = slow[name].pad(time=(0, later)).values, full[name]
        full[f"slow_{name}"] = variable(" ".join(map(str, of.dims)), values, f"{of.long_name}, averaged equations", of.units)
    courses = course_of(motions[0]), course_of(motions[1])
    apart = {"at_equal_angle": at_equal_angle(*courses), "at_equal_phase": at_equal_phase(*courses)}
    largest = {k: d and dict(zip(("speed", "amplitude"), d.largest, strict=True)) for k, d in apart.items()}
    summary = full.wucht.summary | {"slow": slow.wucht.summary, "deviations": largest}
    full = full.assign_attrs(summary=to_json(summary, indent=None), model="both")
    if (by_angle := apart["at_equal_angle"]) is None:
        return full
    speed = variable("compared", by_angle.speed, "speed, full less slow", full.speed.units)
    radius = variable("compared", by_angle.radius, "distance of the axis, full less slow", full.radius.units)
    at = variable("compared", by_angle.at, "angle of the rotor at which the models are compared", "rad")
    return full.assign_coords(compared=at).assign(speed_deviation=speed, radius_deviation=radius)
