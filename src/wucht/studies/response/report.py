"""The answer of a response in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import ReportLines, formats

if TYPE_CHECKING:
    import xarray as xr

_MOST = 6  # maxima named one by one


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a response."""
    s, lines = result.wucht.summary, ReportLines(result)
    speed, length = formats(result, result.amplitude.attrs["units"])
    steady = " where balancing bodies are in stable steady phases" if s["bodies"] == "steady" else ""
    lines.add("range", " to ".join(map(speed, s["range"])))
    lines.add("critical", ", ".join(map(speed, s["critical_speeds"])) or "none")
    if s["peak_speed"] is not None:
        most = "infinite" if s["peak_amplitude"] is None else "{peak_amplitude}"
        lines.add("amplitude", f"{most} at most, at {{peak_speed}}{steady}")
    elif not steady:
        return lines.report(s["sentence"])
    else:
        never = "in no steady phases are the balancing bodies stable"
        lines.add("amplitude", never if s["peak_amplitude"] is None else f"none{steady}")
    others = [m for m in _stable(s["peaks"]) if m["speed"] != s["peak_speed"]]
    if others:
        shown = ["infinite" if m["amplitude"] is None else length(m["amplitude"]) for m in others[:_MOST]]
        named = ", ".join(f"{size} at {speed(m['speed'])}" for size, m in zip(shown, others, strict=False))
        lines.add("also", f"{named} and {len(others) - _MOST} more" if len(others) > _MOST else named)
    lines.add("in operation", "{amplitude_at_free_speed} at {free_speed}")
    if (throw := s["throw_at_free_speed"]) is not None:
        weight = f"{throw['acceleration']:.4g} m/s\u00b2, machine number {throw['machine_number']:.3g}"
        lines.add("", f"stroke {{throw_at_free_speed.stroke}} peak to peak, {weight}")
    if s["peak_torque_speed"] is not None:
        at = [m for m in _stable(s["torque_peaks"])[:_MOST] if m["speed"] != s["peak_torque_speed"]]
        unit = "" if result.wucht.dimensionless else " N m"
        also = "".join(f", also {m['torque']:.4g}{unit} at {speed(m['speed'])}" for m in at)
        lines.add("torque", f"of the vibration: at most {s['peak_torque']:.4g}{unit} at {{peak_torque_speed}}{also}")
    lines.add("self-centred", "from {self_centring_speed} on: the centre of mass runs inside the axis' orbit")
    return lines.report(s["sentence"])


def _stable(maxima: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of bodies in steady phases only where these are stable."""
    return [m for m in maxima if m.get("stable", True)]
