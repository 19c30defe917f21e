"""The verdict in words: what an engineer reads first."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import Format, formats, in_lines

if TYPE_CHECKING:
    import xarray as xr

_SLOW = "  averaged equations"


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a run-up."""
    s = result.wucht.summary
    if "cases" in s:
        return _of_many(result, s)
    speed, length = formats(result, s["amplitude_unit"])
    modulated, time_unit = s["modulation_period"] is not None, "" if result.attrs["dimensionless"] else " s"
    range_ = f", modulated, between {speed(s['min_speed'])} and {speed(s['max_speed'])}" if modulated else ""
    free = f" of {speed(s['free_speed'])} without vibration" if s["free_speed"] is not None else ""
    lines = {"speed": f"{speed(s['final_speed'])}{free}{range_}"}
    if len(s.get("mean_speeds", ())) > 1:
        lines["mean speeds"] = ", ".join(f"{name} {speed(w)}" for name, w in s["mean_speeds"].items())
    if "rotor_phases" in s:
        lines["phase"] = _angles(s["rotor_phases"])
    if s["natural_frequencies"]:
        lines["resonance"] = ", ".join(f"{d}: {speed(f)}" for d, f in s["natural_frequencies"].items())
    lines["amplitude"] = f"{length(s['final_amplitude'])} at the end, {length(s['peak_amplitude'])} at most"
    lines |= _felt(s, length)
    if s["final_phases"]:
        lines["phases"] = _angles(s["final_phases"])
    if s["final_residual_unbalance"] is not None:
        lines["unbalance"] = f"{100 * s['final_residual_unbalance']:.3g} % of the rotor's is left"
    if s["settling_time"] is not None:
        lines["settled at"] = _settled(s, time_unit)
    if modulated:
        turns = s["modulation_period_phi"] / (2 * math.pi)
        lines["modulation"] = f"period {s['modulation_period']:.5g}{time_unit}, {turns:.4g} turns"
        if s["modulation_depth"] is not None:
            lines["modulation"] += f", +-{100 * s['modulation_depth']:.2g} % of the speed averaged over turns"
    if s["dimensionless"] and not result.attrs["dimensionless"]:
        lines["in numbers"] = ", ".join(f"{name} {value:.4g}" for name, value in s["dimensionless"].items())
    if s["energy_residual"] is not None:
        lines["energy"] = f"balance closed to {s['energy_residual']:.1e}"
    if "slow" in s:
        lines["slow"] = f"{s['slow']['outcome']}, {_end(s['slow'], speed, length)}"
    apart = [
        ("apart", f"speed {speed(d['speed'])}, amplitude {length(d['amplitude'])} at most, {name.replace('_', ' ')}")
        for name, d in s.get("deviations", {}).items()
        if d is not None
    ]
    return in_lines(result, f"{s['outcome'].upper()}: {s['sentence']}", [*lines.items(), *apart])


_LINE, _CIRCLE = 0.5, 0.98  # of the motion across over that along: below it throws in a direction, above all are alike
_MOST_ROTORS = 6  # told one by one
_GENTLE = 0.05  # machine number below which the vibration is nothing to speak of


def _felt(s: dict[str, Any], length: Format) -> dict[str, str]:
    """What the vibration at the end is to the machine, and to what lies on it."""
    if s.get("stroke") is None or (s["machine_number"] < _GENTLE and "deck" not in s):
        return {}
    along, across = length(s["stroke"]), length(s["stroke"] * s["throw_ratio"])
    way = "" if s["throw_direction"] is None else f" at {math.degrees(s['throw_direction']):.1f}\u00b0"
    shape = f"{way}, {across} across" if s["throw_ratio"] < _CIRCLE else " on a circle"
    thrown = f"; throw number {s['throw_number']:.3g} of a deck at {math.degrees(s['deck']):.3g}\u00b0" if "deck" in s else ""
    return {
        "throw" if s["throw_ratio"] < _LINE else "stroke": f"{along} peak to peak{shape}",
        "acceleration": f"{s['acceleration']:.4g} m/s\u00b2, machine number {s['machine_number']:.3g}{thrown}",
        "force": f"{_force(s['bearing_force'])} at most, of the bodies on the carrier",
    } | _of_each(s.get("bearing_forces", {}))


def _of_each(forces: dict[str, float]) -> dict[str, str]:
    """The bearing force of each rotor, of many the largest."""
    largest = sorted(forces, key=lambda name: -forces[name])[:_MOST_ROTORS]
    said = ", ".join(f"{name} {_force(f)}" for name, f in forces.items() if name in largest)
    more = f"; {len(forces) - _MOST_ROTORS} more less" if len(forces) > _MOST_ROTORS else ""
    return {"bearings": f"{said} at most, of each rotor on the carrier{more}"} if forces else {}


def _force(value: float) -> str:
    return f"{value / 1e3:.4g} kN" if value >= 1e3 else f"{value:.4g} N"


def _settled(s: dict[str, Any], time_unit: str) -> str:
    """When all has settled; when the speed has, if the amplitude takes longer."""
    speed, amplitude = s["settling_time"], s.get("amplitude_settling_time")
    if amplitude is None:  # where bodies lag it beats for good
        return f"{speed:.4g}{time_unit}, the speed"
    if amplitude <= speed:
        return f"{speed:.4g}{time_unit}"
    return f"{amplitude:.4g}{time_unit}; the speed and the unbalance at {speed:.4g}{time_unit}"


def _angles(phases: dict[str, float]) -> str:
    return ", ".join(f"{name} {math.degrees(phase):.1f}°" for name, phase in phases.items())


def _end(s: dict[str, Any], speed: Format, length: Format) -> str:
    """With what a run ended."""
    return f"{speed(s['final_speed'])}, amplitude {length(s['final_amplitude'])}"


def _of_many(result: xr.Dataset, summary: dict[str, Any]) -> list[str]:
    """A line a case."""
    cases = summary["cases"]
    speed, length = formats(result, cases[0]["amplitude_unit"] if cases else "m")
    lines = [result.attrs["title"], f"verdict: {', '.join(f'{n} {outcome}' for outcome, n in summary['outcomes'].items())}"]
    width = max((len(name) for c in cases for name in (c["label"], _SLOW if "slow" in c else "")), default=0)
    for c in cases:
        lines.append(f"  {c['label']:{width}}  {c['outcome']:20} {_end(c, speed, length)}")
        if "slow" in c:
            apart = c["deviations"]["at_equal_angle"]
            far = "" if apart is None else f"; apart by {speed(apart['speed'])}, {length(apart['amplitude'])} at most"
            lines.append(f"  {_SLOW:{width}}  {c['slow']['outcome']:20} {_end(c['slow'], speed, length)}{far}")
    return lines
