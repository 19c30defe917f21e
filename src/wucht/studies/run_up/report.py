"""The verdict in words: what an engineer reads first."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.conventions import summary_of
from wucht.results.formatting import Format, formats

if TYPE_CHECKING:
    import xarray as xr

_SLOW = "  slow equations"


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a run-up."""
    s = summary_of(result)
    if "cases" in s:
        return _of_many(result, s)
    dimensional = not result.attrs["dimensionless"]
    speed, length = formats(result, s["amplitude_unit"])
    said = [result.attrs["title"], f"verdict: {s['outcome'].upper()}: {s['sentence']}"]
    beating = s["modulation_period"] is not None
    range_ = f", beating between {speed(s['min_speed'])} and {speed(s['max_speed'])}" if beating else ""
    free = f" of {speed(s['free_speed'])} without vibration" if s["free_speed"] is not None else ""
    said.append(f"  speed        {speed(s['final_speed'])}{free}{range_}")
    if "mean_speeds" in s:
        said += _locking(s, speed)
    if s["natural_frequencies"]:
        said.append(f"  resonance    {', '.join(f'{d}: {speed(f)}' for d, f in s['natural_frequencies'].items())}")
    said.append(f"  amplitude    {length(s['final_amplitude'])} at the end, {length(s['peak_amplitude'])} at most")
    if s["final_phases"]:
        shown = [f"{name} {math.degrees(phase):.1f}°" for name, phase in s["final_phases"].items()]
        said.append(f"  phases       {', '.join(shown)}")
    if s["final_residual_unbalance"] is not None:
        said.append(f"  unbalance    {100 * s['final_residual_unbalance']:.3g} % of the rotor's is left")
    if s["settling_time"] is not None:
        said.append(f"  settled at   {s['settling_time']:.4g}{' s' if dimensional else ''}")
    if beating:
        period = f"{s['modulation_period']:.5g}{' s' if dimensional else ''}"
        said.append(f"  modulation   period {period}, {s['modulation_period_phi'] / (2 * math.pi):.4g} turns")
    if s["dimensionless"] and dimensional:
        said.append(f"  in numbers   {', '.join(f'{name} {value:.4g}' for name, value in s['dimensionless'].items())}")
    if s["energy_residual"] is not None:
        said.append(f"  energy       balance closed to {s['energy_residual']:.1e}")
    return said + _of_both(s, speed, length) if "slow" in s else said


def _of_both(s: dict[str, Any], speed: Format, length: Format) -> list[str]:
    """What the slow equations say, and how far they are from the full ones."""
    slow = s["slow"]
    said = [f"  slow         {slow['outcome']}, {speed(slow['final_speed'])}, amplitude {length(slow['final_amplitude'])}"]
    for name, found in s["deviations"].items():
        if found is not None:
            apart = f"speed {speed(found['speed'])}, amplitude {length(found['amplitude'])}"
            said.append(f"  apart        {apart} at most, {name.replace('_', ' ')}")
    return said


def _locking(s: dict[str, Any], speed: Format) -> list[str]:
    """Mean speeds of several rotors, and phases to each other or to the vibration."""
    said = []
    if len(s["mean_speeds"]) > 1:
        said.append(f"  mean speeds  {', '.join(f'{name} {speed(w)}' for name, w in s['mean_speeds'].items())}")
    phases = [f"{name} {math.degrees(phase):.1f}°" for name, phase in s["rotor_phases"].items()]
    return [*said, f"  phase        {', '.join(phases)}"]


def _of_many(result: xr.Dataset, summary: dict[str, Any]) -> list[str]:
    """A line a case."""
    cases = summary["cases"]
    speed, length = formats(result, cases[0]["amplitude_unit"] if cases else "m")
    said = [
        result.attrs["title"],
        f"verdict: {', '.join(f'{n} {outcome}' for outcome, n in summary['outcomes'].items())}",
    ]
    width = max((len(name) for c in cases for name in (c["label"], _SLOW if "slow" in c else "")), default=0)
    for c in cases:
        end = f"{speed(c['final_speed'])}, amplitude {length(c['final_amplitude'])}"
        said.append(f"  {c['label']:{width}}  {c['outcome']:20} {end}")
        if "slow" in c:
            apart = c["deviations"]["at_equal_angle"]
            far = "" if apart is None else f"; apart by {speed(apart['speed'])}, {length(apart['amplitude'])} at most"
            slow = c["slow"]
            ended = f"{speed(slow['final_speed'])}, amplitude {length(slow['final_amplitude'])}"
            said.append(f"  {_SLOW:{width}}  {slow['outcome']:20} {ended}{far}")
    return said
