"""Numbers in pages that results state: ``<!-- = FILE OPTIONS | NAME UNIT -->0.459<!-- = -->``, filled in by ``make numbers``.

FILE is a name of the catalogue, a file of the page itself (a block of TOML with a title), or a kind of study, whose template
is then run. OPTIONS are those of ``wucht run``: ``--set KEY=VALUE``. Without both, ``<!-- = | NAME -->``, they are those of the
mark before. NAME is a path in the summary of the result, such as ``final_amplitude``, ``cut_residuals[0]`` or
``cases[drive=e1].speed``, or of a variable over time: ``mean speed.b1`` or ``half-range radius`` in its last twentieth,
``largest speed.drum`` in all of it. A number has as many decimals as the page shows, a text stands in backquotes. A number that
the result has as one of many is refused: it is of one draw, and no fact.
"""

from __future__ import annotations

import re
import shlex
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from wucht.cli.options import parse_settings
from wucht.studies.study_file import StudyFile

from . import gallery, page_figures

PAGES = gallery.ROOT / "docs"
_MARK = re.compile(r"(?<!`)<!-- = (?:([^\s|]\S*)((?: --set \S+)*) )?\| ([^>]+?) -->(.*?)<!-- = -->")
# Functions of a variable over time, and the last share of the run that they are of.
_OF_VARIABLES: dict[str, tuple[Callable[[np.ndarray], float], float]] = {
    "mean": (lambda values: float(values.mean()), 1 / 20),
    "half-range": (lambda values: float(np.ptp(values)) / 2, 1 / 20),
    "largest": (lambda values: float(values.max()), 1.0),
}


@dataclass(frozen=True)
class PageNumber:
    """A marked number of a page: where it comes from, its unit (empty: as in the summary), and the text that stands there."""

    file: str
    options: str
    name: str
    unit: str
    text: str

    @classmethod
    def from_mark(cls, mark: re.Match[str], before: PageNumber | None) -> PageNumber:
        """Read a mark. before: the number before it on the page. Raises ``ValueError`` for one that cannot be read."""
        *function, path = words = mark[3].split()
        unit = ""
        if len(words) > 1 and (len(words) > 2 or words[0] not in _OF_VARIABLES):
            *function, path, unit = words
        if len(function) > 1 or (function and function[0] not in _OF_VARIABLES):
            raise ValueError(f"{mark[3]!r} must be a path in the summary and a unit, or one of {', '.join(_OF_VARIABLES)}")
        if mark[1] is None and before is None:
            raise ValueError(f"{mark[3]!r} must name its file: no mark stands before it")
        file, options = (mark[1], mark[2].strip()) if before is None or mark[1] else (before.file, before.options)
        return cls(file, options, " ".join([*function, path]), unit, mark[4])

    def study(self, folder: Path) -> StudyFile:
        """The study whose result states it. folder: of the page's files. Raises ``InputError``."""
        return page_figures.study_of(self.file, parse_settings(shlex.split(self.options)[1::2]), folder)

    def filled(self, result: Any) -> str:
        """The text that should stand there. Raises ``KeyError`` where the result does not have it, ``ValueError`` where it
        depends on the last digit."""
        value, unit = self._value(result)
        if isinstance(value, str):
            return f"`{value}`"
        return as_written(self.text, _converted(float(value), unit, self.unit))

    def _value(self, result: Any) -> tuple[Any, str]:
        function, _, path = self.name.rpartition(" ")
        if function:
            first, _, body = path.partition(".")
            values = result[first].sel(body=body) if body else result[first]
            of, share = _OF_VARIABLES[function]
            late = result.time.values >= result.time.values[-1] * (1 - share)
            return of(values.values[late]), result[first].attrs["units"]
        if path.partition(".")[0] in result.wucht.summary.get("one_of_many", ()):
            raise ValueError(f"{self.file} {self.options}: {path} is one of many, a page cannot state it")
        return _at(result.wucht.summary, path), result.wucht.unit_at(re.sub(r"\[.*?\]", "", path))


def _at(value: Any, path: str) -> Any:
    """What stands at a path. Raises ``LookupError``, and ``ValueError`` where not exactly one item of a list fits."""
    if not path:
        return value
    if path.startswith("["):
        item, _, rest = path[1:].partition("]")
        name, _, which = item.rpartition("=")
        (value,) = [one for one in value if str(one[name]) == which] if name else [value[int(which)]]
    else:  # keys may have dots, as paths of parameters have
        (key,) = [key for key in value if re.match(rf"{re.escape(key)}(?![^.\[])", path)] or [path]
        value, rest = value[key], path.removeprefix(key)
    return _at(value, rest.removeprefix("."))


@cache
def _units() -> Any:
    import pint

    return pint.UnitRegistry()


def _converted(value: float, unit: str, to: str) -> float:
    """A value in another unit; a share in per cent."""
    if not to or to == unit:
        return value
    if to == "%":
        return 100 * value
    return float(_units().Quantity(value, unit).to(to).magnitude)


def as_written(text: str, value: float) -> str:
    """A value as a number is written in a text: with as many decimals, as a power of ten where that is one."""
    mantissa, power, _ = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    written = f"{value:.{decimals}{'e' if power else 'f'}}"
    return re.sub(r"e([+-])0*(\d)", lambda m: f"e{m[1].replace('+', '')}{m[2]}", written)


def numbers_of(page: str) -> list[PageNumber]:
    """The marked numbers of a page, in order."""
    numbers: list[PageNumber] = []
    for mark in _MARK.finditer(page):
        numbers.append(PageNumber.from_mark(mark, numbers[-1] if numbers else None))
    return numbers


def without_numbers(page: str) -> str:
    """A page with a bar in the place of each marked number."""
    return _MARK.sub("|", page)


def with_numbers(page: str) -> str:
    """A page with its marked numbers as the results state them. A result is kept as those of the gallery are."""
    results: dict[tuple[str, str], Any] = {}
    numbers = iter(numbers_of(page))
    with tempfile.TemporaryDirectory() as folder:
        page_figures.write_files(page, Path(folder))

        def filled(mark: re.Match[str]) -> str:
            number = next(numbers)
            question = number.file, number.options
            if question not in results:
                kept = gallery.KEPT / "numbers" / gallery.key(*question)
                results[question] = gallery.result_of(number.study(Path(folder)), kept)
            return mark[0].removesuffix(f"{mark[4]}<!-- = -->") + f"{number.filled(results[question])}<!-- = -->"

        return _MARK.sub(filled, page)


def pages_with_numbers() -> Iterator[Path]:
    """The pages that have marked numbers."""
    yield from (path for path in sorted(PAGES.rglob("*.md")) if _MARK.search(path.read_text(encoding="utf-8")))


def main() -> None:
    """Fill the numbers of all pages, or of those whose paths are given, and print what changes."""
    for path in map(Path, sys.argv[1:]) if len(sys.argv) > 1 else pages_with_numbers():
        page = path.read_text(encoding="utf-8")
        new_page = with_numbers(page)
        for before, after in zip(numbers_of(page), numbers_of(new_page), strict=True):
            if before != after:
                sys.stdout.write(f"{path}: {before.name} {before.options}: {before.text} -> {after.text}\n")
        path.write_text(new_page, encoding="utf-8")


if __name__ == "__main__":
    main()
