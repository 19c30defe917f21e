"""The torques of a start from rest, as text in reports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wucht.results.formatting import ReportLines


def add_starting_line(lines: ReportLines, summary: Mapping[str, Any]) -> None:
    """Add the line on the torques at standstill, where a drive does not start its rotor from rest."""
    torques = summary.get("starting_torque", {})
    if any(torques[name] > 0 and not starts for name, starts in summary.get("starts_from_rest", {}).items()):
        lines.add("from rest", "{starting_torque} at standstill; weight at most {weight_moment}; load {load_torque}")
