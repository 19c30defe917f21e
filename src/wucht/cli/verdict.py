"""The verdict in words: what an engineer reads first."""

from __future__ import annotations

import math
from typing import Any


def verdict_lines(document: dict[str, Any]) -> list[str]:
    """The lines that ``wucht run`` prints for a run-up."""
    s = document["summary"]
    dimensional = document["units"] == "SI"
    speed, length = (_si_speed, _si_length) if dimensional else (_plain, _plain)
    lines = [f"{document['machine']}", f"verdict: {s['outcome'].upper()}: {s['sentence']}"]
    beating = s["modulation_period"] is not None
    range_ = f", beating between {speed(s['min_speed'])} and {speed(s['max_speed'])}" if beating else ""
    free = f" of {speed(s['free_speed'])} without vibration" if s["free_speed"] is not None else ""
    lines.append(f"  speed        {speed(s['final_speed'])}{free}{range_}")
    lines.append(f"  resonance    {', '.join(f'{d}: {speed(f)}' for d, f in s['natural_frequencies'].items())}")
    lines.append(f"  amplitude    {length(s['final_amplitude'])} at the end, {length(s['peak_amplitude'])} at most")
    if s["final_phases"]:
        shown = [f"{name} {math.degrees(phase):.1f}°" for name, phase in s["final_phases"].items()]
        lines.append(f"  phases       {', '.join(shown)}")
    if s["final_residual_unbalance"] is not None:
        lines.append(f"  unbalance    {100 * s['final_residual_unbalance']:.3g} % of the rotor's is left")
    if s["settling_time"] is not None:
        lines.append(f"  settled at   {s['settling_time']:.4g}{' s' if dimensional else ''}")
    if beating:
        period = f"{s['modulation_period']:.5g}{' s' if dimensional else ''}"
        lines.append(f"  modulation   period {period}, {s['modulation_period_phi'] / (2 * math.pi):.4g} turns")
    if s["dimensionless"] and document["units"] == "SI":
        lines.append(f"  in numbers   {', '.join(f'{name} {value:.4g}' for name, value in s['dimensionless'].items())}")
    if s["energy_residual"] is not None:
        lines.append(f"  energy       balance closed to {s['energy_residual']:.1e}")
    return lines


def _plain(value: float | None) -> str:
    return "none" if value is None else f"{value:.5g}"


def _si_speed(value: float | None) -> str:
    return "none" if value is None else f"{value:.5g} rad/s ({value * 30 / math.pi:.0f} rpm)"


def _si_length(value: float | None) -> str:
    if value is None:
        return "none"
    return f"{value * 1e3:.4g} mm" if abs(value) >= 1e-5 else f"{value * 1e6:.3g} um"
