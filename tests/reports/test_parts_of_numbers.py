"""A number of several parts in the report: each has its own name and unit, as in the summary."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import wucht as package


def test_each_part_has_its_own_unit(wucht: Callable[..., Any], tmp_path: Path) -> None:
    """The breakdown of a motor: a slip, a speed and a torque."""
    result = package.run_file("practice/screen", {"study.kind": "torque-balance"}, folder=tmp_path / "screen")
    assert wucht("report", str(tmp_path / "screen"), "-o", "report.html").code == 0
    page, parts = Path("report.html").read_text(encoding="utf-8"), result.wucht.summary["breakdown"]
    cell = page.partition("Largest torque of an induction motor</th><td>")[2].partition("</td>")[0]
    slip, speed, torque = cell.split("<br>")
    assert slip == f"slip: {parts['slip']:.4g}"
    assert speed.startswith(f"speed: {parts['speed']:.5g} rad/s (")
    assert torque == f"torque of the drive: {parts['torque']:.5g} N·m"
