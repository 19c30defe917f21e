"""The answer of a response in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr

_MOST = 6  # maxima named one by one


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a response."""
    s = result.wucht.summary
    speed, length = formats(result, result.amplitude.attrs["units"])

    def amplitude(value: float | None, at: float, most: str = "") -> str:
        return f"{'infinite' if value is None else length(value)}{most} at {speed(at)}"

    lines = [result.attrs["title"], f"verdict: {s['sentence']}"]
    lines.append(f"  range        {speed(s['range'][0])} to {speed(s['range'][1])}")
    lines.append(f"  critical     {', '.join(speed(c) for c in s['critical_speeds']) or 'none'}")
    if s["peak_speed"] is not None:
        lines.append(f"  amplitude    {amplitude(s['peak_amplitude'], s['peak_speed'], ' at most,')}{_bodies(s)}")
    elif s["bodies"] == "held":
        return lines
    elif s["peak_amplitude"] is not None:
        lines.append(f"  amplitude    none{_bodies(s)}")
    else:
        lines.append("  amplitude    in no steady phases are the balancing bodies stable")
    others = [amplitude(p["amplitude"], p["speed"]) for p in _stable(s["peaks"]) if p["speed"] != s["peak_speed"]]
    if others:
        more = f" and {len(others) - _MOST} more" if len(others) > _MOST else ""
        lines.append(f"  also         {', '.join(others[:_MOST])}{more}")
    if s["free_speed"] is not None and s["amplitude_at_free_speed"] is not None:
        lines.append(f"  in operation {amplitude(s['amplitude_at_free_speed'], s['free_speed'])}")
        if (t := s["throw_at_free_speed"]) is not None:
            stroke = f"stroke {length(t['stroke'])} peak to peak"
            lines.append(
                f"               {stroke}, {t['acceleration']:.4g} m/s\u00b2, machine number {t['machine_number']:.3g}"
            )
    if s["peak_torque_speed"] is not None:
        unit = "" if result.attrs["dimensionless"] else " N m"
        at = [(p["speed"], p["torque"]) for p in _stable(s["torque_peaks"])[:_MOST] if p["speed"] != s["peak_torque_speed"]]
        shown = [f"{torque:.4g}{unit} at {speed(w)}" for w, torque in [(s["peak_torque_speed"], s["peak_torque"]), *at]]
        lines.append(f"  torque       of the vibration: at most {', also '.join(shown)}")
    if s["self_centring_speed"] is not None:
        centred = speed(s["self_centring_speed"])
        lines.append(f"  self-centred from {centred} on: the centre of mass runs inside the axis' orbit")
    return lines


def _stable(maxima: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of bodies in steady phases only where these are stable."""
    return [m for m in maxima if m.get("stable", True)]


def _bodies(s: dict[str, Any]) -> str:
    return " where balancing bodies are in stable steady phases" if s["bodies"] == "steady" else ""
