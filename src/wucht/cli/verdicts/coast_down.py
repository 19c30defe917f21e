"""The verdict of a coast-down in words."""

from __future__ import annotations

from typing import Any

from wucht.cli.verdicts.units import speaking


def lines(document: dict[str, Any]) -> list[str]:
    """The lines that ``wucht run`` prints for a coast-down."""
    s = document["summary"]
    second = " s" if document["units"] == "SI" else ""
    speed, length = speaking(document)
    label = "" if s["outcome"] is None else f"{s['outcome'].upper()}: "
    said = [document["machine"], f"verdict: {label}{s['sentence']}"]
    said.append(f"  speed        {speed(s['start_speed'])} at the start, {speed(s['final_speed'])} on average at the end")
    half = "not within this time" if s["half_time"] is None else f"after {s['half_time']:.5g}{second}"
    said.append(f"  halved       {half}")
    if s["reversal_time"] is not None:
        said.append(f"  turns back   at {s['reversal_time']:.6g}{second}")
    said.append(f"  turned       {s['turns']:.5g} times in {s['end_time']:.5g}{second}")
    if s["peak_amplitude"]:
        said.append(f"  amplitude    {length(s['peak_amplitude'])} at most")
    said.append(f"  energy       balance closed to {s['energy_residual']:.1e}")
    return said
