"""Numbers of a run that a neighbouring run does not confirm: one draw of many."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES
from wucht.numerics.angles import wrap_to_pi
from wucht.results.quantities import StudyResult, group

ONE_OF_MANY = "one_of_many"
_ALIKE = 1e-4  # of a number, or of a turn: as much as is printed
_MOST_NAMES = 4  # in the warning
_START = "1e-6 rad"  # ``neighbours.DISPLACEMENT``
_ROUNDING = 1e-6  # of the largest number in the unit, below which numbers are zero
_NO_RESULTS = ("energy_residual", "damper_mismatch", "natural_frequencies", "dimensionless", "advice", "amplitude_unit")


def with_neighbour(run_result: StudyResult, neighbour: StudyResult, growth: float) -> StudyResult:
    """Return the result of a run with what a run from a neighbouring start has in place of its numbers, where they differ."""
    of_neighbour = {q.name: q for q in neighbour.quantities if q.dimensions is None or q.in_summary}
    numbers = [q for q in run_result.quantities if (q.dimensions is None or q.in_summary) and q.name not in _NO_RESULTS]
    sizes = dict[str, float]()
    for q in numbers:
        sizes[q.unit] = max(sizes.get(q.unit, 0.0), _size(q.value))
    outcomes = run_result.summary["outcome"], neighbour.summary["outcome"]
    if any(outcome in OPEN_OUTCOMES for outcome in outcomes):  # what one of both leaves open is no difference
        numbers = [
            q
            for q in numbers
            if q.name not in ("outcome", "advised_time") and None not in (q.value, neighbour.summary.get(q.name))
        ]
    differing = [
        replace(of_neighbour[q.name], headline=False)
        for q in numbers
        if q.name in of_neighbour and not _are_alike(q.value, of_neighbour[q.name].value, q.unit, sizes[q.unit])
    ]
    if not differing:
        return run_result
    names, more = ", ".join(q.long_name for q in differing[:_MOST_NAMES]), len(differing) - _MOST_NAMES
    count = "1 number is" if len(differing) == 1 else f"{len(differing)} numbers are"
    warning = (
        f"the run amplifies differences 1e{math.floor(math.log10(growth))} times, and {count} one draw of many ({names}"
        f"{f' and {more} more' if more > 0 else ''}): a start {_START} away gives those in {ONE_OF_MANY}, several "
        "starts show their spread; all other numbers hold"
    )
    if "outcome" in {q.name for q in differing}:
        warning = f"the outcome is chance: a start {_START} away ends as {outcomes[1]}; {warning}"
    elif outcomes[0] in OPEN_OUTCOMES and outcomes[1] not in OPEN_OUTCOMES:
        warning = f"a start {_START} away ends as {outcomes[1]}; {warning}"
    draw = group(ONE_OF_MANY, differing, f"numbers that are chance, from a start {_START} away")
    return replace(run_result, quantities=[*run_result.quantities, draw], warnings=[*run_result.warnings, warning])


def _size(value: Any) -> float:
    """The largest of some numbers, in magnitude; 0 for a text or None."""
    if isinstance(value, Mapping | list | tuple):
        return max(map(_size, value.values() if isinstance(value, Mapping) else value), default=0.0)
    return abs(float(value)) if isinstance(value, int | float) and math.isfinite(value) else 0.0


def _are_alike(a: Any, b: Any, unit: str, size: float) -> bool:
    """True if two values, or all of two tables or vectors, are alike. size: below a millionth of which a number is zero."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_are_alike(x, b[name], unit, size) for name, x in a.items())
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        of_vector = max(size, _size(a) * _ALIKE / _ROUNDING)
        return len(a) == len(b) and all(_are_alike(x, y, unit, of_vector) for x, y in zip(a, b, strict=True))
    if not (isinstance(a, int | float) and isinstance(b, int | float)):
        return bool(a == b)
    if unit == "rad" and abs(float(wrap_to_pi(a - b))) <= _ALIKE * 2 * math.pi:
        return True
    return math.isclose(a, b, rel_tol=_ALIKE, abs_tol=_ROUNDING * size)
