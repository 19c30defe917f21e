"""What the catalogue's files answer, computed once: results and figures are kept in a folder that git ignores.

A result is taken from there as long as the file's question and the code that answers it are the same; its figure as long as
the code that draws it is, too.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import wucht
from wucht.files.catalogue import names
from wucht.plots.sheet import save_figure
from wucht.studies.study_file import StudyFile, read_study, run_study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "build" / "gallery"
_SOURCE = Path(wucht.__file__).parent
# Longer than half a minute on two cores: computed when all are asked for.
EXPENSIVE = frozenset(
    {
        "drozdetskaya-2020/figure-5.9a",
        "drozdetskaya-2020/how-likely-it-compensates",
        "drozdetskaya-2020/how-the-rotating-orbit-disappears",
        "practice/exciter-design",
        "practice/washing-machine-ring",
        "sperling-rollers/damping-optimum",
    }
)
_WORDS = ("figure", "keys", "report")  # code on which no number depends, as that of whole floors:
_FLOORS = ("cli", "plots")


@dataclass(frozen=True)
class Entry:
    """A file of the catalogue with its answer. result: None where it was not computed. thumbnail: one panel of the figure."""

    name: str
    study_file: StudyFile
    about: dict[str, Any]
    result: Any | None
    figure: Path
    thumbnail: Path


@cache
def digest(numbers_alone: bool = False) -> str:
    """Of the code, or of that on which numbers depend."""
    made = sha256(wucht.__version__.encode())
    for file in sorted(_SOURCE.rglob("*.py")):
        place = file.relative_to(_SOURCE)
        if not (numbers_alone and (place.parts[0] in _FLOORS or place.stem.startswith(_WORDS))):
            made.update(place.as_posix().encode() + file.read_bytes())
    return made.hexdigest()


def key(*texts: str) -> str:
    """A name of texts: the same ones have the same."""
    return sha256("\n".join(texts).encode()).hexdigest()


def entry(name: str, compute: bool = True) -> Entry:
    """The answer of a file of the catalogue: kept from an earlier call, or computed now, if that is wanted."""
    from wucht.files.catalogue import load_document

    study_file, folder = read_study(name), KEPT / name
    about, _ = load_document(name)
    result, figure, thumbnail = answer(study_file, folder, compute)
    return Entry(name, study_file, about, result, figure, thumbnail)


def answer(study_file: StudyFile, folder: Path, compute: bool = True) -> tuple[Any | None, Path, Path]:
    """The result of a study with its figure and one panel of that, kept in a folder; None as result where it is not there."""
    result = result_of(study_file, folder, compute)
    figure, thumbnail = folder / f"{study_file.spec.kind}.png", folder / "thumbnail.png"
    drawn = key(_question(study_file), digest(False))
    if result is not None and text_of(folder / "drawn") != drawn:
        whole = wucht.draw(result)
        save_figure(whole, figure)
        _save_panel(whole, thumbnail)
        (folder / "drawn").write_text(drawn, encoding="utf-8")
    return result, figure, thumbnail


def result_of(study_file: StudyFile, folder: Path, compute: bool = True) -> Any | None:
    """The result of a study, kept in a folder; None where it is not there."""
    question = _question(study_file)
    if text_of(folder / "question") == question:
        return wucht.load(folder / "result.nc")
    if not compute:
        return None
    shutil.rmtree(folder, ignore_errors=True)
    result = run_study(study_file, folder=folder)
    (folder / "question").write_text(question, encoding="utf-8")
    return result


def _question(study_file: StudyFile) -> str:
    return key(repr(study_file.document), digest(True))


def _save_panel(figure: Figure, path: Path) -> None:
    """Save the first panel of a figure alone, with its scales and without legends: what can be read in a thumbnail."""
    place = figure.axes[0].get_position().bounds  # a second scale has the same
    elsewhere = [axis for axis in figure.axes if axis.get_position().bounds != place]
    for axis in elsewhere:
        axis.set_visible(False)
    for axis in (axis for axis in figure.axes if axis not in elsewhere):
        axis.set_position(_PANEL)
        if axis.get_legend() is not None:
            axis.get_legend().remove()
    for text in (*figure.texts, *figure.legends):
        text.set_visible(False)
    figure.suptitle("")
    figure.set_size_inches(_PANEL_SIZE)
    figure.savefig(path, dpi=_DOTS_AN_INCH, bbox_inches="tight")


_PANEL, _PANEL_SIZE, _DOTS_AN_INCH = (0.15, 0.2, 0.7, 0.7), (3.6, 2.4), 110  # of the figure; in; of a thumbnail


def text_of(file: Path) -> str:
    return file.read_text(encoding="utf-8") if file.is_file() else ""


__all__ = ["EXPENSIVE", "KEPT", "ROOT", "Entry", "answer", "entry", "names"]
