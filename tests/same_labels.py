"""``python -m tests.same_labels [PATTERN...] [--base COMMIT]``: do verdicts, counts and labels depend on the last digits?

Every template and catalogue file is answered twice, with products and sums fused in machine code and without, or, with
``--base``, by a commit and by the working tree: all that is no floating-point number must be the same. How far the numbers of
the summaries differ is printed. Patterns as of ``tests.same_answers``, which keeps the answers.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from tests.answering import ANSWER, OUT
from tests.same_answers import LEFT_OUT, Case, Tree, cases, without_times

_SMALLEST = 1e-12  # smaller numbers are rounding
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def differences(one: Path, other: Path) -> Iterator[str]:
    """The labels and counts that two answers, each a folder, have not in common: a line each."""
    yield from _differences(_given(one), _given(other), "given")
    yield from _differences(*(_labels(_summary(folder / OUT / "summary.json")) for folder in (one, other)), "summary")
    yield from _differences(*(_variables(folder / OUT / "result.nc") for folder in (one, other)), "variable")


def _given(folder: Path) -> Any:
    """Exit code and messages, whose numbers may differ."""
    given = json.loads((folder / ANSWER).read_text(encoding="utf-8"))["given"]
    return {"exit code": given["exit code"], "errors": _labels(without_times(given["errors"]))}


def _summary(file: Path) -> Any:
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else None


def _labels(value: Any) -> Any:
    """A value without its floating-point numbers, of which only that they are there remains."""
    if isinstance(value, dict):
        return {key: _labels(one) for key, one in value.items() if key not in LEFT_OUT}
    if isinstance(value, list):
        return [_labels(one) for one in value]
    if isinstance(value, str):
        return _NUMBER.sub("#", value)
    return "a number" if isinstance(value, float) else value


def _variables(file: Path) -> dict[str, Any]:
    """Of each variable its shape, and its values if these are labels or counts."""
    if not file.exists():
        return {}
    with xr.open_dataset(file) as result:
        return {str(name): _shape_and_labels(variable.values) for name, variable in result.variables.items()}


def _shape_and_labels(values: np.ndarray) -> list[Any]:
    return [list(values.shape), *([] if values.dtype.kind in "fcmM" else [_labels(values.tolist())])]


def _differences(a: Any, b: Any, path: str) -> Iterator[str]:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in a | b:
            yield from _differences(a.get(key), b.get(key), f"{path}/{key}")
    elif a != b:
        yield f"{path}: {a!r:.150} != {b!r:.150}"


def largest_difference(one: Path, other: Path) -> float:
    """The largest relative difference of the numbers of two summaries; of small ones beside the others of their list."""
    return max(_relative(*(_summary(folder / OUT / "summary.json") for folder in (one, other))), default=0.0)


def _relative(a: Any, b: Any, scale: float = 0.0) -> Iterator[float]:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in a.keys() & b.keys() - LEFT_OUT:
            if "residual" not in key:
                yield from _relative(a[key], b[key])
    elif isinstance(a, list) and isinstance(b, list):
        largest = max((abs(v) for v in (*a, *b) if isinstance(v, float)), default=0.0)
        for pair in zip(a, b, strict=False):
            yield from _relative(*pair, largest)
    elif isinstance(a, float) and isinstance(b, float) and a != b:
        yield abs(a - b) / max(abs(a), abs(b), scale, _SMALLEST)


def main() -> int:
    """Compare, print each difference, and return 1 if there is one."""
    parser = argparse.ArgumentParser(prog="python -m tests.same_labels", description=__doc__)
    parser.add_argument("patterns", nargs="*", default=["*"], help="of cases, such as 'practice/*'; default: all")
    parser.add_argument("--base", help="a commit, to compare with in place of the working tree without fused products")
    options = parser.parse_args()
    new = Tree.of(None).written()
    base = replace(new, answers="answers-unfused", is_fused=False) if options.base is None else Tree.of(options.base).written()
    chosen = [c for c in cases() if c.kind != "hostile" and any(fnmatch(c.name, p) for p in options.patterns)]
    failed = 0

    def compare(case: Case) -> tuple[list[str], float]:
        answers = base.answer(case), new.answer(case)
        return list(differences(*answers)), largest_difference(*answers)

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for case, (lines, largest) in zip(chosen, pool.map(compare, chosen), strict=True):
            failed += bool(lines)
            heading = f"{'DIFFERS' if lines else 'same   '} {case.name}  (numbers differ by {largest:.1e})"
            sys.stdout.write("\n        ".join([heading, *lines[:20]]) + "\n")
            sys.stdout.flush()
    sys.stdout.write(f"{len(chosen)} cases: {failed} have other labels or counts\n")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
