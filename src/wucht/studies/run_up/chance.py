"""Numbers of a run that a neighbouring run does not confirm: one draw of many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES
from wucht.numerics.alike_numbers import are_alike, largest_number
from wucht.results.quantities import Quantity, group
from wucht.studies.answer import Answer

ONE_OF_MANY = "one_of_many"
_MOST_NAMES = 4  # in the warning
_START = "1e-6 rad"  # ``neighbours.DISPLACEMENT``
_NO_RESULTS = ("energy_residual", "damper_mismatch", "natural_frequencies", "dimensionless", "advice", "amplitude_unit")


def differing_numbers(run_result: Answer, neighbour: Answer) -> list[Quantity]:
    """Return what a run from a neighbouring start has in place of the numbers of a run, where they differ."""
    of_neighbour = {q.name: q for q in neighbour.quantities if q.dimensions is None or q.in_summary}
    numbers = [q for q in run_result.quantities if (q.dimensions is None or q.in_summary) and q.name not in _NO_RESULTS]
    sizes = dict[str, float]()
    for q in numbers:
        sizes[q.unit] = max(sizes.get(q.unit, 0.0), largest_number(q.value))
    outcomes = run_result.summary["outcome"], neighbour.summary["outcome"]
    if any(outcome in OPEN_OUTCOMES for outcome in outcomes):  # what one of both leaves open is no difference
        numbers = [
            q
            for q in numbers
            if q.name not in ("outcome", "advised_time") and None not in (q.value, neighbour.summary.get(q.name))
        ]
    return [
        replace(of_neighbour[q.name], headline=False)
        for q in numbers
        if q.name in of_neighbour and not are_alike(q.value, of_neighbour[q.name].value, q.unit, sizes[q.unit])
    ]


def state_chance(a: Answer, differing: Sequence[Quantity], outcome: str, of_neighbour: str, growth: float) -> None:
    """State the numbers of a neighbouring run that differ. outcome, of_neighbour: of both. growth: of their difference."""
    if not differing:
        return
    names, more = ", ".join(q.long_name for q in differing[:_MOST_NAMES]), len(differing) - _MOST_NAMES
    count = "1 number is" if len(differing) == 1 else f"{len(differing)} numbers are"
    warning = (
        f"the run amplifies differences 1e{math.floor(math.log10(growth))} times, and {count} one draw of many ({names}"
        f"{f' and {more} more' if more > 0 else ''}): a start {_START} away gives those in {ONE_OF_MANY}, several "
        "starts show their spread; all other numbers hold"
    )
    if "outcome" in {q.name for q in differing}:
        warning = f"the outcome is chance: a start {_START} away ends as {of_neighbour}; {warning}"
    elif outcome in OPEN_OUTCOMES and of_neighbour not in OPEN_OUTCOMES:
        warning = f"a start {_START} away ends as {of_neighbour}; {warning}"
    a.warn(warning)
    a.add([group(ONE_OF_MANY, differing, f"numbers that are chance, from a start {_START} away")])
