"""The lines that ``wucht run`` prints for a run-up."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.results.bearing_text import force_text, life_text
from wucht.results.formatting import Format, ReportLines, formats
from wucht.results.starting_text import add_starting_line
from wucht.studies.run_up.chance import ONE_OF_MANY
from wucht.studies.run_up.system_run_result import system_run_report

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

_SLOW = "  averaged equations"


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a run-up."""
    s = result.wucht.summary
    if result.attrs.get("subject") == "system":
        return system_run_report(result)
    if "cases" in s:
        return _case_lines(result, s)
    speed, length = formats(result, s["amplitude_unit"])
    lines, time = ReportLines(result), "" if result.wucht.dimensionless else " s"
    chance = s.get(ONE_OF_MANY, {})

    def mark(*keys: str) -> str:
        return " (one of many)" if any(key in chance for key in keys) else ""

    is_modulated = s["modulation_period"] is not None
    free = " of {free_speed} without vibration" if s["free_speed"] else ""  # nothing drives a rotor that vibration sustains
    lines.add(
        "speed",
        "{final_speed}"
        + free
        + (", modulated, between {min_speed} and {max_speed}" if is_modulated else "")
        + mark("final_speed", *(("min_speed", "max_speed") if is_modulated else ())),
    )
    if len(s.get("mean_speeds", ())) > 1:
        speeds = ", ".join(f"{n} {speed(w)}" for n, w in s["mean_speeds"].items())
        lines.add("mean speeds", "{speeds}" + mark("mean_speeds"), speeds=speeds)
    if "rotor_phases" in s:
        lines.add("phase", "{phases}" + mark("rotor_phases"), phases=_angles(s["rotor_phases"]))
    add_starting_line(lines, s)
    if s["natural_frequencies"]:
        lines.add("resonance", "{natural_frequencies}")
    lines.add(
        "amplitude",
        f"{{final_amplitude}} at the end{mark('final_amplitude')}, {{peak_amplitude}} at most{mark('peak_amplitude')}",
    )
    _vibration(lines, s, mark)
    _bearings(lines, s, mark)
    if s["final_phases"]:
        lines.add("phases", "{phases}" + mark("final_phases"), phases=_angles(s["final_phases"]))
        remains = ": more than without bodies" if "unbalance_factor" in s else " remains"
        lines.add("unbalance", f"{{final_residual_unbalance:%}} of the rotor's{remains}{mark('final_residual_unbalance')}")
    if s["settling_time"] is not None:
        lines.add("settled at", _settling_text(s, time) + mark("settling_time", "amplitude_settling_time"))
    if is_modulated:
        turns = s["modulation_period_phi"] / (2 * math.pi)
        depth = ", +-{modulation_depth:.2g%} of the speed averaged over turns" if s["modulation_depth"] is not None else ""
        lines.add(
            "modulation",
            f"period {{modulation_period:.5g}}, {turns:.4g} turns{depth}{mark('modulation_period', 'modulation_depth')}",
        )
    if s["dimensionless"] and not result.wucht.dimensionless:
        lines.add("in numbers", ", ".join(f"{name} {value:.4g}" for name, value in s["dimensionless"].items()))
    _contacts(lines, s, mark)
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    if "slow" in s:
        lines.add("slow", f"{s['slow']['outcome']}, {_end(s['slow'], speed, length)}")
    for name, deviation in s.get("deviations", {}).items():
        if deviation is not None:
            lines.add(
                "deviation",
                f"speed {{speed}}, amplitude {{amplitude}} at most, {name.replace('_', ' ')}",
                deviation,
                "deviations",
            )
    return lines.report(f"{s['outcome'].upper()}: {s['sentence']}")


_CIRCLE = 0.98  # ratio of the stroke across to that along: above it, the motion is a circle
_MOST_ROTORS = 6  # named one by one
_GENTLE = 0.05  # machine number below which the vibration is negligible


def _vibration(lines: ReportLines, s: dict[str, Any], mark: Callable[..., str]) -> None:
    """Add lines on the vibration at the end: the load on the machine, and on the goods that it carries."""
    if s.get("stroke") is None or (s["machine_number"] < _GENTLE and "deck" not in s):
        return
    ratio = s["throw_ratio"] or 0.0
    across = lines.format_value(s["stroke"] * ratio, "m")
    way = "" if s["throw_direction"] is None else f" at {math.degrees(s['throw_direction']):.1f}\u00b0"
    shape = f"{way}, {across} across" if ratio < _CIRCLE else " on a circle"
    throw_text = f"; throw number {{throw_number:.3g}} of a deck at {math.degrees(s['deck']):.3g}\u00b0" if "deck" in s else ""
    lines.add("stroke", f"{{stroke}} peak to peak{shape}{mark('stroke', 'throw_direction', 'throw_ratio')}")
    acceleration = f"{s['acceleration']:.4g} m/s\u00b2, machine number {{machine_number:.3g}}{throw_text}"
    lines.add("acceleration", acceleration + mark("acceleration", "machine_number", "throw_number"))
    lines.add("force", f"{force_text(s['bearing_force'])} at most, of the bodies on the carrier{mark('bearing_force')}")


def _bearings(lines: ReportLines, s: dict[str, Any], mark: Callable[..., str]) -> None:
    """Add lines on the forces of several rotors, or of one whose bearing has a rating, and on the life of bearings."""
    life, forces = life_text(s), s.get("steady_bearing_forces", {})
    if forces and (life or (len(forces) > 1 and s.get("machine_number", 0.0) >= _GENTLE)):
        text = _bearing_forces(forces, s["bearing_forces"], s["peak_bearing_forces"])
        chance = mark("steady_bearing_forces", "bearing_forces", "peak_bearing_forces")
        lines.add("bearings", "{forces}" + chance, forces=text)
    if life:
        lines.add("bearing life", "{life}" + mark("bearing_life", "equivalent_bearing_loads"), life=life)


def _bearing_forces(steady: dict[str, float], largest: dict[str, float], peak: dict[str, float]) -> str:
    """Return the force of each rotor on its bearing at the end, and the largest of the run; of many rotors, the largest."""
    first = sorted(steady, key=lambda name: -largest[name])[:_MOST_ROTORS]
    listing = ", ".join(f"{n} {force_text(f)} ({force_text(largest[n])} at most)" for n, f in steady.items() if n in first)
    more = f"; {len(steady) - _MOST_ROTORS} smaller ones" if len(steady) > _MOST_ROTORS else ""
    return f"{listing} at the end{more}; {force_text(max(peak.values()))} at most in the whole run"


def _settling_text(s: dict[str, Any], time_unit: str) -> str:
    """Return the settling time, that of the speed; and that of the amplitude, if it takes longer."""
    speed, amplitude = s["settling_time"], s.get("amplitude_settling_time")
    if amplitude is None:  # with lagging bodies it beats permanently
        return f"{speed:.4g}{time_unit}, the speed"
    if amplitude <= speed:
        return f"{speed:.4g}{time_unit}"
    return f"{speed:.4g}{time_unit}; the amplitude at {amplitude:.4g}{time_unit}"


def _contacts(lines: ReportLines, s: dict[str, Any], mark: Callable[..., str]) -> None:
    """Add lines on the contacts of balls, and how far these overlap at most."""
    for track, frequency in s.get("contact_frequencies", {}).items():
        angle, overlap = s["overlaps"].get(track), ""
        if angle is not None:
            length = lines.format_value(s["overlap_lengths"][track], "m")
            overlap = f"; bodies overlap by {length} at most, {math.degrees(angle):.2g}\u00b0" if angle else "; none has closed"
        lines.add("contacts", f"of {frequency:.4g} rad/s{overlap}{mark('overlaps', 'overlap_lengths')}")
    if (stiffness := s.get("contact_check")) is not None:
        amplitude, residual = s["contact_check_amplitude"], s["contact_check_residual"]
        parts = [] if amplitude is None else [f"the largest amplitude changes by {100 * amplitude:.2g} %"]
        parts += [] if residual is None else [f"the remaining unbalance by {100 * residual:.2g} % of the rotor's"]
        parts += [] if s["contact_check_outcome"] == s["outcome"] else [f"the outcome is {s['contact_check_outcome']}"]
        lines.add("", f"{stiffness}, {', '.join(parts) or 'nothing is known of changes'}")


def _angles(phases: dict[str, float]) -> str:
    return ", ".join(f"{name} {math.degrees(phase):.1f}°" for name, phase in phases.items())


def _end(s: dict[str, Any], speed: Format, length: Format) -> str:
    """Return the final speed and amplitude of a run."""
    return f"{speed(s['final_speed'])}, amplitude {length(s['final_amplitude'])}"


def _case_lines(result: xr.Dataset, summary: dict[str, Any]) -> list[str]:
    """Return a line for each case."""
    cases = summary["cases"]
    speed, length = formats(result, cases[0]["amplitude_unit"] if cases else "m")
    lines = [result.attrs["title"], f"verdict: {', '.join(f'{n} {outcome}' for outcome, n in summary['outcomes'].items())}"]
    width = max((len(name) for c in cases for name in (c["label"], _SLOW if "slow" in c else "")), default=0)
    for c in cases:
        lines.append(f"  {c['label']:{width}}  {c['outcome']:20} {_end(c, speed, length)}")
        if "slow" in c:
            deviation = c["deviations"]["at_equal_angle"]
            far = (
                ""
                if deviation is None
                else f"; deviation {speed(deviation['speed'])}, {length(deviation['amplitude'])} at most"
            )
            lines.append(f"  {_SLOW:{width}}  {c['slow']['outcome']:20} {_end(c['slow'], speed, length)}{far}")
    return lines
