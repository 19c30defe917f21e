"""The scale below the drawing of a machine: where it stands, and that it is as long as it says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.web.page_answers import answer, page_text

SIZES = [[640, 480], [480, 640], [1280, 400], [320, 240], [200, 700], [500, 500]]
MAGNIFICATION, MOTION, STEPS = 10.0, 0.004, 37
BAND = 26.0  # px: the height of a line of words with its room


def drawings(folder: Path, name: str) -> list[tuple[list[int], Any]]:
    """Each size with what is drawn on a canvas of it; the axis moves to the right along a line."""
    trace = np.column_stack([np.linspace(0, MOTION, STEPS), np.zeros(STEPS)]).ravel().tolist()
    job = {"sizes": SIZES, "magnification": MAGNIFICATION, "trace": trace}
    return list(zip(SIZES, answer(folder, page_text(name), "drawings", **job), strict=True))


def length_of(words: str) -> float:
    """In mm of the drawn machine, whose motion is magnified."""
    number, unit, *rest = words.split()
    return float(number) * {"mm": 1.0, "µm": 1e-3}[unit] * (MAGNIFICATION if rest == ["of", "motion"] else 1.0)


def test_the_scale_stands_below_the_machine_and_is_as_long_as_it_says(tmp_path: Path) -> None:
    """A bar of the machine, and one of its motion; the line on which its axis moves is the measure of both."""
    for (width, height), drawn in drawings(tmp_path, "drozdetskaya-2020/r1"):
        lines = [np.array(stroke["points"]) for stroke in drawn["strokes"] if stroke["points"]]
        (moved,) = (np.ptp(line[:, 0]) for line in lines if len(line) == STEPS)
        bars = [line for line in lines if line[:, 1].min() > height - BAND]
        words = [entry for entry in drawn["words"] if entry["words"].split()[1:2] in (["mm"], ["µm"])]
        assert len(bars) == len(words) == 2
        for bar, entry in zip(bars, words, strict=True):
            left, right, top, bottom = *np.sort(bar[:, 0])[[0, -1]], *np.sort(bar[:, 1])[[0, -1]]
            x, y = entry["point"]
            assert 0 < left < right < x < width and top < y < bottom < height
            assert (right - left) / moved == pytest.approx(length_of(entry["words"]) / (1e3 * MAGNIFICATION * MOTION), rel=1e-9)
        others = [line[:, 1].max() for line in lines if line[:, 1].min() <= height - BAND]
        assert max(others) < min(bar[:, 1].min() for bar in bars)


def test_where_nothing_is_to_scale_words_say_so_at_the_same_place(tmp_path: Path) -> None:
    for (width, height), drawn in drawings(tmp_path, "drozdetskaya-2020/table-5.1"):
        ((x, y),) = (entry["point"] for entry in drawn["words"] if entry["words"] == "not to scale")
        assert 0 < x < width and height - BAND < y < height
