"""Figures as files, in the format of the ending of their names."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.plots.page import made_for
from wucht.plots.sheet import page_of
from wucht.results.store import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure in the format of the path's ending."""
    # Packed a third faster than by default, and a tenth larger.
    packing: dict[str, Any] = {"pil_kwargs": {"compress_level": 1}} if path.suffix == ".png" else {}
    with warnings.catch_warnings(), made_for(page_of(figure)):
        warnings.filterwarnings("ignore", "Glyph", UserWarning)  # a title in a script that the font lacks
        return replacing(path, lambda beside: figure.savefig(beside, format=path.suffix[1:], **packing))
