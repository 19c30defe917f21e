"""The pictures of the README and of pages: ``python -m docs.site.pictures`` draws them anew, small, mostly from the gallery.

They are the only drawn files in the repository: a page on a code host has no other way to show them. All together stay below
``LARGEST`` bytes.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import wucht
from wucht.plots.style import COLOURS, GREY

from .gallery import ROOT, entry

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FOLDER = ROOT / "docs" / "pictures"
LARGEST = 560_000
PICTURES = {
    "run-up": "practice/laundry-drum",
    "speed-curve": "drozdetskaya-2020/figure-5.2",
    "basin": "drozdetskaya-2020/figure-5.10",
}
_DOTS_AN_INCH, _COLOURS = 110, 128


def main() -> None:
    """Draw all of them."""
    FOLDER.mkdir(exist_ok=True)
    for name, of in PICTURES.items():
        _save(wucht.draw(entry(of).result), FOLDER / f"{name}.png")
    for name, drawing in DRAWINGS.items():
        _save(drawing(), FOLDER / f"{name}.png")


def stroke_and_amplitude() -> Figure:
    """Draw the ellipse of the carrier's centre of mass with stroke, direction of the throw, and amplitude."""
    from matplotlib.figure import Figure

    semi_major, semi_minor, inclination = 1.0, 0.28, np.radians(35.0)
    angle = np.linspace(0.0, 2 * np.pi, 400)
    along = np.array([np.cos(inclination), np.sin(inclination)])
    across = np.array([-along[1], along[0]])
    x, y = semi_major * np.cos(angle) * along[:, None] + semi_minor * np.sin(angle) * across[:, None]
    figure = Figure(figsize=(5.2, 3.4), layout="constrained")
    axis = figure.subplots()
    axis.plot(x, y, color=COLOURS[0], linewidth=1.4)
    axis.plot([0], [0], "+", color="black", markersize=9)
    axis.axhline(0.0, color=GREY, linewidth=0.6)
    arc = np.linspace(0.0, inclination, 50)
    axis.plot(0.9 * np.cos(arc), 0.9 * np.sin(arc), color=COLOURS[2], linewidth=1.0)
    axis.text(0.95, 0.17, "direction of the throw", color=COLOURS[2], fontsize=9)
    shift = 0.45 * across
    ends = [shift - semi_major * along, shift + semi_major * along]
    _arrow(axis, *ends, "<->", COLOURS[1])
    axis.text(
        *(shift + 0.12 * across), "stroke, peak to peak", color=COLOURS[1], fontsize=9, rotation=35, ha="center", va="center"
    )
    _arrow(axis, np.zeros(2), -semi_major * along, "->", COLOURS[0])
    axis.text(-0.40, -0.13, "amplitude, 0 to peak", color=COLOURS[0], fontsize=9, rotation=35, ha="center", va="center")
    axis.text(0.04, -0.10, "static position", fontsize=8)
    axis.set(aspect="equal", xticks=[], yticks=[], xlim=(-1.25, 2.0), ylim=(-0.85, 1.05), xlabel="x", ylabel="y")
    return figure


def _arrow(axis: Axes, begin: np.ndarray, end: np.ndarray, style: str, colour: str) -> None:
    axis.annotate("", end, begin, arrowprops={"arrowstyle": style, "color": colour, "shrinkA": 0, "shrinkB": 0})


DRAWINGS = {"stroke": stroke_and_amplitude}


def _save(figure: Figure, path: Path) -> None:
    """Save a figure in few colours."""
    from PIL import Image

    drawn = BytesIO()
    figure.savefig(drawn, format="png", dpi=_DOTS_AN_INCH)
    Image.open(drawn).convert("RGB").quantize(_COLOURS).save(path, optimize=True)


if __name__ == "__main__":
    main()
