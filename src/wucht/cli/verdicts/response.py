"""The verdict of a response in words."""

from __future__ import annotations

from typing import Any

from wucht.cli.verdicts.units import Speaker, plain, speaking

_MOST = 6  # maxima named one by one


def lines(document: dict[str, Any]) -> list[str]:
    """The lines that ``wucht run`` prints for a response."""
    s = document["summary"]
    dimensional = document["units"] == "SI"
    speed, length = speaking(document)
    if set(s["natural_frequencies"]) == {"r"}:
        length = _angle if dimensional else plain
    said = [f"{document['machine']}", f"verdict: {s['sentence']}"]
    said.append(f"  range        {speed(s['range'][0])} to {speed(s['range'][1])}")
    said.append(f"  critical     {', '.join(speed(c) for c in s['critical_speeds']) or 'none'}")
    if s["peak_speed"] is None:
        return said
    said.append(f"  amplitude    {_amplitude(s['peak_amplitude'], length)} at most, at {speed(s['peak_speed'])}")
    others = [p for p in s["peaks"] if p["speed"] != s["peak_speed"]]
    if others:
        shown = [f"{_amplitude(p['amplitude'], length)} at {speed(p['speed'])}" for p in others[:_MOST]]
        more = f" and {len(others) - _MOST} more" if len(others) > _MOST else ""
        said.append(f"  also         {', '.join(shown)}{more}")
    if s["free_speed"] is not None:
        said.append(f"  in operation {_amplitude(s['amplitude_at_free_speed'], length)} at {speed(s['free_speed'])}")
    if s["peak_torque_speed"] is not None:
        unit = " N m" if dimensional else ""
        at = [(p["speed"], p["torque"]) for p in s["torque_peaks"][:_MOST] if p["speed"] != s["peak_torque_speed"]]
        shown = [f"{torque:.4g}{unit} at {speed(w)}" for w, torque in [(s["peak_torque_speed"], s["peak_torque"]), *at]]
        said.append(f"  torque       of the vibration: at most {', also '.join(shown)}")
    if s["self_centring_speed"] is not None:
        said.append(f"  self-centred from {speed(s['self_centring_speed'])} on: the centre of mass runs inside the axis' orbit")
    return said


def _amplitude(value: float | None, length: Speaker) -> str:
    return "infinite" if value is None else length(value)


def _angle(value: float | None) -> str:
    return "none" if value is None else f"{value:.4g} rad"
