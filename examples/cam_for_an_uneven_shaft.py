"""From a motion task and a measured record to the list of points to mill, and the check that the motion will be clean.

A slide is to rest for 240 degrees of the cam and make a stroke of 24 degrees, with five harmonics. The camshaft fluctuates: an
encoder has recorded 7.4 turns, with noise and unevenly sampled. The record is synthetic, so that the true motion is known.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

import wucht

MEAN, COSINE, SINE = 500 * math.pi / 30, (0.0, 2.4, 1.0, 0.5, 0.3), (0.0, 1.0, -1.3, 0.2, 0.4)  # rad/s

TASK = """
title = "A clean dwell on an uneven shaft"

[study]
kind = "cam-correction"

[law]
kind = "harmonic"
harmonics = 5
[[law.restrictions]]
at = "180 deg"
equals = "24 deg"
[[law.restrictions]]
on = ["-120 deg", "120 deg"]
equals = "0 deg"

[follower]
kind = "oscillating-roller"
pivot = "120 mm"
arm = "70 mm"
roller_radius = "10 mm"
angle = "-135 deg"

[speed]
file = "record.csv"
column = "speed"
orders = [2, 3, 4, 5]
"""


def write_record(path: Path) -> None:
    """Write times in s and speeds in rpm: 7.4 turns, sampled unevenly, with noise of 2 rpm."""
    random = np.random.default_rng(4)
    t = np.sort(random.uniform(0, 7.4 * 2 * math.pi / MEAN, 20_000))
    speed = np.full(len(t), MEAN)
    for j, (a, b) in enumerate(zip(COSINE, SINE, strict=True), 1):
        speed += a * np.cos(j * MEAN * t) + b * np.sin(j * MEAN * t)
    rpm = speed * 30 / math.pi + random.normal(0, 2, len(t))
    rows = "\n".join(f"{x:.9f}, {y:.4f}" for x, y in zip(t, rpm, strict=True))
    path.write_text(f"time [s], speed [rpm]\n{rows}\n")


def main(folder: Path) -> None:
    """Write the record, the task, the figure and the files for the workshop into a folder, and print the results."""
    folder.mkdir(parents=True, exist_ok=True)
    write_record(folder / "record.csv")
    (folder / "task.toml").write_text(TASK)
    corrected = wucht.run_file(folder / "task.toml")
    print("\n".join(wucht.report(corrected)))
    wucht.draw(corrected).savefig(folder / "cam-correction.png")
    contour = wucht.run_file(folder / "task.toml", {"study.kind": "cam-contour", "study.corrected": True})
    print("\n".join(wucht.export(contour, folder / "mill")))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "cam-for-an-uneven-shaft"))
