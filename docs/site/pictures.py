"""The pictures of the README and of the first page: ``python -m docs.site.pictures`` draws them anew, small, from the gallery.

They are the only drawn files in the repository: a page on a code host has no other way to show them. All together stay below
``LARGEST`` bytes.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import wucht

from .gallery import ROOT, entry

FOLDER = ROOT / "docs" / "pictures"
LARGEST = 300_000
PICTURES = {
    "run-up": "practice/laundry-drum",
    "speed-curve": "drozdetskaya-2020/figure-5.2",
    "basin": "drozdetskaya-2020/figure-5.10",
}
_DOTS_AN_INCH, _COLOURS = 90, 128


def main() -> None:
    """Draw all of them."""
    FOLDER.mkdir(exist_ok=True)
    for name, of in PICTURES.items():
        _small(of, FOLDER / f"{name}.png")


def _small(name: str, path: Path) -> None:
    """The figure of a file of the catalogue, in few colours."""
    from PIL import Image

    drawn = BytesIO()
    wucht.draw(entry(name).result).savefig(drawn, format="png", dpi=_DOTS_AN_INCH)
    Image.open(drawn).convert("RGB").quantize(_COLOURS).save(path, optimize=True)


if __name__ == "__main__":
    main()
