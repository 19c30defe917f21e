"""Numbers in pages that results state: ``<!-- = FILE OPTIONS | NAME UNIT -->0.459<!-- = -->``, filled in by ``make numbers``.

FILE is a name of the catalogue, OPTIONS are those of ``wucht run``: ``--set KEY=VALUE``. NAME is a path in the summary of the
result, such as ``final_amplitude`` or ``rotor_phases.e2``, or of a variable over time ``mean speed.b1`` or
``half-range radius``, of its last twentieth. A number has as many decimals as the page shows, a text stands in backquotes.
"""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from wucht.cli.options import parse_settings
from wucht.studies.study_file import StudyFile, read_study

from . import gallery

PAGES = gallery.ROOT / "docs"
_MARK = re.compile(r"(?<!`)<!-- = (\S+)((?: --set \S+)*) \| ([^>]+?) -->(.*?)<!-- = -->")
_OF_VARIABLES: dict[str, Callable[[np.ndarray], float]] = {
    "mean": lambda values: float(values.mean()),
    "half-range": lambda values: float(np.ptp(values)) / 2,
}
_PART = 20  # of a run: its last part


@dataclass(frozen=True)
class PageNumber:
    """A marked number of a page: where it comes from, its unit (empty: as in the summary), and the text that stands there."""

    file: str
    options: str
    name: str
    unit: str
    text: str

    @classmethod
    def from_mark(cls, mark: re.Match[str]) -> PageNumber:
        """Read a mark. Raises ``ValueError`` for one that is not written as it should be."""
        *function, path = words = mark[3].split()
        unit = ""
        if len(words) > 1 and (len(words) > 2 or words[0] not in _OF_VARIABLES):
            *function, path, unit = words
        if len(function) > 1 or (function and function[0] not in _OF_VARIABLES):
            raise ValueError(f"{mark[3]!r} must be a path in the summary and a unit, or one of {', '.join(_OF_VARIABLES)}")
        return cls(mark[1], mark[2].strip(), " ".join([*function, path]), unit, mark[4])

    def study(self) -> StudyFile:
        """The study whose result states it. Raises ``InputError``."""
        return read_study(self.file, parse_settings(shlex.split(self.options)[1::2]))

    def filled(self, result: Any) -> str:
        """The text that should stand there. Raises ``KeyError`` where the result does not have it."""
        value, unit = self._value(result)
        if isinstance(value, str):
            return f"`{value}`"
        return as_written(self.text, _converted(float(value), unit, self.unit))

    def _value(self, result: Any) -> tuple[Any, str]:
        function, _, path = self.name.rpartition(" ")
        first, *rest = path.split(".")
        if function:
            values = result[first].sel(body=rest[0]) if rest else result[first]
            late = result.time.values >= result.time.values[-1] * (1 - 1 / _PART)
            return _OF_VARIABLES[function](values.values[late]), result[first].attrs["units"]
        value, facts = result.wucht.summary[first], result.wucht.quantities[first]
        for key in rest:
            value, facts = value[int(key) if isinstance(value, list) else key], facts.get("parts", {}).get(key, facts)
        return value, facts.get("unit", "")


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
    return [PageNumber.from_mark(mark) for mark in _MARK.finditer(page)]


def with_numbers(page: str) -> str:
    """A page with its marked numbers as the results state them. A result is kept as those of the gallery are."""

    def filled(mark: re.Match[str]) -> str:
        number = PageNumber.from_mark(mark)
        folder = gallery.KEPT / "numbers" / gallery.key(number.file, number.options)
        result, _, _ = gallery.answer(number.study(), folder)
        return mark[0].removesuffix(f"{mark[4]}<!-- = -->") + f"{number.filled(result)}<!-- = -->"

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
