"""Figures in pages that the program draws: at ``<!-- figure: FILE OPTIONS | CAPTION -->``.

FILE is a name of the catalogue, a file that the page itself has (a block of TOML with a title), or a kind of study, whose
template is then drawn. OPTIONS are those of ``wucht run``: ``--set KEY=VALUE``.
"""

from __future__ import annotations

import re
import shlex
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wucht.cli.options import parse_settings
from wucht.files.catalogue import names
from wucht.studies.registry import studies
from wucht.studies.study_file import StudyFile, read_study

from . import gallery

MARK = re.compile(r"^<!-- figure: (\S+)(.*?) \| (.+?) -->$", re.MULTILINE)
_FILE = re.compile(r'^```(?:toml|csv) title="(.+?)"\n(.*?)^```$', re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class PageFigure:
    """A mark in a page: the file, what is set, and the words below the figure."""

    file: str
    settings: dict[str, Any]
    caption: str

    @classmethod
    def from_mark(cls, mark: re.Match[str]) -> PageFigure:
        """Read a mark. Raises ``ValueError`` for an option other than ``--set``."""
        words = shlex.split(mark[2])
        if words[::2] != ["--set"] * (len(words) // 2) or len(words) % 2:
            raise ValueError(f"only --set KEY=VALUE may follow the file of a figure, not {mark[2]}")
        return cls(mark[1], parse_settings(words[1::2]), mark[3])

    def study(self, folder: Path) -> StudyFile:
        """The study that is drawn. folder: of the page's files. Raises ``InputError``."""
        return study_of(self.file, self.settings, folder)

    @property
    def is_in_gallery(self) -> bool:
        """True if the gallery has it: a file of the catalogue as it is."""
        return self.file in names() and not self.settings


def study_of(file: str, settings: dict[str, Any], folder: Path) -> StudyFile:
    """A study that a page names: a file in the folder of its own ones, a kind of study, or a name of the catalogue."""
    of_page = folder / file
    if file in studies():
        of_page.write_text(studies()[file].template or "", encoding="utf-8")
    return read_study(str(of_page) if of_page.is_file() else file, settings)


def figures_of(page: str) -> list[PageFigure]:
    """The figures that a page asks for, in order."""
    return [PageFigure.from_mark(mark) for mark in MARK.finditer(page)]


def write_files(page: str, folder: Path) -> None:
    """Write the files that a page has as blocks with a title."""
    for title, text in _FILE.findall(page):
        (folder / title).write_text(text, encoding="utf-8")


def with_figures(name: str, page: str, compute: bool = True) -> tuple[str, dict[str, Path]]:
    """A page with its marks replaced by pictures, and these by their file names beside the page.

    name: of the page, such as ``practice/screen.md``. compute: what is not kept from an earlier call; a figure that is
    neither is left out.
    """
    if not MARK.search(page):
        return page, {}
    place, pictures = Path(name).with_suffix(""), dict[str, Path]()
    with tempfile.TemporaryDirectory() as folder:
        write_files(page, Path(folder))

        def picture(mark: re.Match[str]) -> str:
            figure = PageFigure.from_mark(mark)
            drawn = _drawn(figure, Path(folder), gallery.KEPT / "pages" / place / str(len(pictures) + 1), compute)
            if drawn is None:
                return ""
            file = f"{place.name}-{len(pictures) + 1}.png"
            pictures[(place.parent / file).as_posix()] = drawn
            return "\n".join(_lines(figure, file))

        return MARK.sub(picture, page), pictures


def _drawn(figure: PageFigure, files: Path, kept: Path, compute: bool) -> Path | None:
    """The picture of a figure, from the gallery where that has it."""
    if figure.is_in_gallery:
        one = gallery.entry(figure.file, compute=compute and figure.file not in gallery.EXPENSIVE)
        return None if one.result is None else one.figure
    result, path, _ = gallery.answer(figure.study(files), kept, compute)
    return None if result is None else path


def _lines(figure: PageFigure, file: str) -> Iterator[str]:
    yield from ('<figure markdown="span">', f"![{figure.caption}]({file})", f"<figcaption>{figure.caption}</figcaption>")
    yield "</figure>"
