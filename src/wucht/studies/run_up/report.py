"""The verdict in words: what an engineer reads first."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import Format, ReportLines, formats

if TYPE_CHECKING:
    import xarray as xr

_SLOW = "  averaged equations"


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a run-up."""
    s = result.wucht.summary
    if "cases" in s:
        return _of_many(result, s)
    speed, length = formats(result, s["amplitude_unit"])
    lines, time = ReportLines(result), "" if result.wucht.dimensionless else " s"
    modulated = s["modulation_period"] is not None
    free = " of {free_speed} without vibration" if s["free_speed"] is not None else ""
    lines.add("speed", "{final_speed}" + free + (", modulated, between {min_speed} and {max_speed}" if modulated else ""))
    if len(s.get("mean_speeds", ())) > 1:
        lines.add("mean speeds", "{speeds}", speeds=", ".join(f"{n} {speed(w)}" for n, w in s["mean_speeds"].items()))
    if "rotor_phases" in s:
        lines.add("phase", "{phases}", phases=_angles(s["rotor_phases"]))
    if s["natural_frequencies"]:
        lines.add("resonance", "{natural_frequencies}")
    lines.add("amplitude", "{final_amplitude} at the end, {peak_amplitude} at most")
    _vibration(lines, s)
    if s["final_phases"]:
        lines.add("phases", "{phases}", phases=_angles(s["final_phases"]))
    lines.add("unbalance", "{final_residual_unbalance:%} of the rotor's is left")
    if s["settling_time"] is not None:
        lines.add("settled at", _settled(s, time))
    if modulated:
        turns = s["modulation_period_phi"] / (2 * math.pi)
        depth = ", +-{modulation_depth:.2g%} of the speed averaged over turns" if s["modulation_depth"] is not None else ""
        lines.add("modulation", f"period {{modulation_period:.5g}}, {turns:.4g} turns{depth}")
    if s["dimensionless"] and not result.wucht.dimensionless:
        lines.add("in numbers", ", ".join(f"{name} {value:.4g}" for name, value in s["dimensionless"].items()))
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    if "slow" in s:
        lines.add("slow", f"{s['slow']['outcome']}, {_end(s['slow'], speed, length)}")
    for name, apart in s.get("deviations", {}).items():
        if apart is not None:
            lines.add(
                "apart", f"speed {{speed}}, amplitude {{amplitude}} at most, {name.replace('_', ' ')}", apart, "deviations"
            )
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}")


_LINE, _CIRCLE = 0.5, 0.98  # of the motion across over that along: below it throws in a direction, above all are alike
_MOST_ROTORS = 6  # named one by one
_GENTLE = 0.05  # machine number below which the vibration is nothing to speak of


def _vibration(lines: ReportLines, s: dict[str, Any]) -> None:
    """What the vibration at the end is to the machine, and to what lies on it."""
    if s.get("stroke") is None or (s["machine_number"] < _GENTLE and "deck" not in s):
        return
    across = lines.written(s["stroke"] * s["throw_ratio"], "m")
    way = "" if s["throw_direction"] is None else f" at {math.degrees(s['throw_direction']):.1f}\u00b0"
    shape = f"{way}, {across} across" if s["throw_ratio"] < _CIRCLE else " on a circle"
    thrown = f"; throw number {{throw_number:.3g}} of a deck at {math.degrees(s['deck']):.3g}\u00b0" if "deck" in s else ""
    lines.add("throw" if s["throw_ratio"] < _LINE else "stroke", f"{{stroke}} peak to peak{shape}")
    lines.add("acceleration", f"{s['acceleration']:.4g} m/s\u00b2, machine number {{machine_number:.3g}}{thrown}")
    lines.add("force", f"{_force(s['bearing_force'])} at most, of the bodies on the carrier")
    forces = s.get("bearing_forces", {})
    if forces:
        lines.add("bearings", "{forces}", forces=_of_each(forces))


def _of_each(forces: dict[str, float]) -> str:
    """The bearing force of each rotor, of many the largest."""
    largest = sorted(forces, key=lambda name: -forces[name])[:_MOST_ROTORS]
    shown = ", ".join(f"{name} {_force(f)}" for name, f in forces.items() if name in largest)
    more = f"; {len(forces) - _MOST_ROTORS} more less" if len(forces) > _MOST_ROTORS else ""
    return f"{shown} at most, of each rotor on the carrier{more}"


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
