"""All that a result says, compared with what is stated of it: so that nothing in it changes unnoticed.

Other tests check a few numbers of a result against something independent. This compares every line of its report, every key of
its summary, and of every variable how many numbers it has, their range and mean, with ``tests/stated/NAME.json``; of a figure
the words and the range of all that is drawn. A change that is meant is stated anew with ``WUCHT_STATE=1 make test`` and read in
the difference.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wucht import report

FOLDER = Path(__file__).with_name("stated")
# Another processor or another version of a library changes the last bits, which the longest runs raise to 1e-5.
TOLERANCE, SMALLEST = 2e-4, 1e-9
_ANGLES = ("direction", "phase")  # in keys of angles: of the size of a radian, however near to zero they are
_IN_WORDS = 2e-3  # numbers of a sentence have four digits
_HEADING = 15  # characters of a line of a report before its text
_LONGEST = 12  # of a list that is stated whole
_ABSENT = "nothing"
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def check(name: str, result: xr.Dataset, figure: Figure | None = None) -> None:
    """Compare a result, and its figure, with what is stated under this name."""
    actual = json.loads(json.dumps(_facts(result, figure)))
    file = FOLDER / f"{name.replace('/', '-')}.json"
    if os.environ.get("WUCHT_STATE"):
        FOLDER.mkdir(exist_ok=True)
        lines = (f" {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in sorted(actual.items()))
        file.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    stated = json.loads(file.read_text(encoding="utf-8"))
    differences = list(_differences(actual, stated, ""))
    assert not differences, f"{file.name}:\n" + "\n".join(differences[:20])


def _facts(result: xr.Dataset, figure: Figure | None) -> dict[str, Any]:
    """What is compared, each entry under a key of its own: a line of the file."""
    facts: dict[str, Any] = {}
    for line in report(result):
        facts.setdefault(f"report {line[:_HEADING].strip()}", []).append(_in_words(line[_HEADING:].strip()))
    facts |= {f"summary {key}": _brief(value) for key, value in result.wucht.summary.items()}
    facts |= {f"variable {key}": _brief(variable.values) for key, variable in result.variables.items()}
    if figure is not None:
        for k, axis in enumerate(figure.axes):
            words = [axis.get_title(), axis.get_xlabel(), axis.get_ylabel(), *(text.get_text() for text in axis.texts)]
            if (legend := axis.get_legend()) is not None:
                words += [text.get_text() for text in legend.get_texts()]
            facts[f"panel {k}"] = [word for word in words if word]
            facts[f"panel {k} range"] = [*axis.get_xlim(), *axis.get_ylim()]
            drawn = [_range(line.get_xdata(), line.get_ydata()) for line in axis.get_lines()]
            drawn += [_range(*np.ma.filled(c.get_offsets(), np.nan).T) for c in axis.collections]
            facts[f"panel {k} drawn"] = drawn
    return facts


def _range(x: Any, y: Any) -> list[Any]:
    return [_brief(np.asarray(x, float)), _brief(np.asarray(y, float))]


def _in_words(text: str) -> str:
    """A sentence in which numbers below 1e-6, which are rounding errors, are all the same."""
    return re.sub(r"\d(?:\.\d+)?e-(?:0[7-9]|[1-9]\d)", "1e-9", text)


def _brief(value: Any) -> Any:
    """A value as it can be compared: of many numbers their count, range and mean."""
    if isinstance(value, Mapping):
        return {str(key): _brief(one) for key, one in value.items()}
    array = np.asarray(value)
    if array.dtype.kind in "biufcM" and array.size > _LONGEST:
        return _statistics(array)
    if isinstance(value, np.ndarray):
        return [_brief(one) for one in value.ravel().tolist()]
    if isinstance(value, list | tuple):
        return [_brief(one) for one in value[:_LONGEST]] + ([len(value)] if len(value) > _LONGEST else [])
    return _single(value)


def _statistics(array: np.ndarray) -> dict[str, Any]:
    numbers = np.concatenate([array.real.ravel(), array.imag.ravel()]) if array.dtype.kind == "c" else array.astype(float)
    finite = numbers[np.isfinite(numbers)]
    statistics = [finite.min(), finite.max(), np.abs(finite).mean(), finite.mean()] if finite.size else []
    return {"size": [array.size, int(finite.size)], "of": [_digits(float(one)) for one in statistics]}


def _single(value: Any) -> Any:
    if isinstance(value, complex):
        return [_digits(value.real), _digits(value.imag)]
    if isinstance(value, float):
        return _digits(value)
    return value if value is None or isinstance(value, bool | int) else _in_words(str(value))


def _digits(value: float) -> float | str:
    return float(f"{value:.6g}") if math.isfinite(value) else str(value)


def _differences(actual: Any, stated: Any, path: str) -> Iterator[str]:
    """Each place where two values are not the same."""
    if isinstance(actual, dict) and isinstance(stated, dict):
        for key in {**stated, **actual}:
            yield from _differences(actual.get(key, _ABSENT), stated.get(key, _ABSENT), f"{path}/{key}")
    elif isinstance(actual, list) and isinstance(stated, list) and len(actual) == len(stated):
        scale = max((abs(one) for one in stated if _is_number(one)), default=0.0)
        for k, (a, b) in enumerate(zip(actual, stated, strict=True)):
            if not (_is_number(a) and _is_number(b) and abs(a - b) <= 1e-3 * TOLERANCE * scale):
                yield from _differences(a, b, f"{path}/{k}")
    elif _is_number(actual) and _is_number(stated):
        smallest = 1e-3 * TOLERANCE if path.endswith(_ANGLES) else SMALLEST
        if abs(actual - stated) > TOLERANCE * abs(stated) + smallest:
            yield f"{path}: {actual}, stated {stated}"
    elif isinstance(actual, str) and isinstance(stated, str):
        if not _same_words(actual, stated):
            yield f"{path}: {actual!r}, stated {stated!r}"
    elif actual != stated:
        yield f"{path}: {actual}, stated {stated}"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _same_words(actual: str, stated: str) -> bool:
    """The same letters, and the same numbers but for the last digit."""
    if _NUMBER.split(actual) != _NUMBER.split(stated):
        return False
    pairs = zip(_NUMBER.findall(actual), _NUMBER.findall(stated), strict=True)
    return all(a == b or abs(float(a) - float(b)) <= _IN_WORDS * abs(float(b)) for a, b in pairs)
