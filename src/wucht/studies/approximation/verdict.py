"""Whether the slow equations may be trusted for a machine, and why not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from wucht.machines.machine import Machine
from wucht.studies.approximation.comparison import Comparison

if TYPE_CHECKING:
    from wucht.studies.approximation.order import Errors
    from wucht.studies.approximation.study import Approximation

TRUSTED = 0.05  # of the largest speed up to until_phi: a deviation beyond it is not small
AMPLITUDE_TRUSTED = 0.25  # of the largest amplitude: that of a carrier that starts at rest is not in the slow equations
LEAST_ORDER = 0.7  # of the nominal order: below, epsilon is not small enough for the error to fall with it


def summary_of(
    machine: Machine,
    question: Approximation,
    own: Comparison | None,
    compared: Sequence[Comparison],
    measured: Errors | None,
    unmeasured: str,
    whose: str,
) -> dict[str, Any]:
    """The summary. own: the comparison of the machine's own values; unmeasured: why there is no ``measured`` order.

    whose: the speeds that were compared, in words. ``trusted`` is None where nothing speaks against it but not all is known.
    """
    key = question.along[0] if len(question.along) == 1 else "factor"
    found: dict[str, Any] = {
        "along": list(question.along) if len(question.along) != 1 else question.along[0],
        "deviations": [{key: c.value} | _told(c) for c in compared],
        "own": None if own is None else _told(own),
        "disagreement": regions(compared),
        "errors": None if measured is None else dict(zip(map(str, measured.factors), measured.speed, strict=True)),
        "order_of_error": None if measured is None or math.isinf(measured.order) else measured.order,
        "nominal_order": None if measured is None else measured.nominal,
        "speeds_of": whose,
        "along_unit": machine.parameters[question.along[0]].unit if len(question.along) == 1 else "",
        "amplitude_unit": machine.orbit_unit,
        "until_phi": question.until_phi,
    }
    doubts, undecided = _doubts(own, measured, whose), _undecided(own, unmeasured)
    trusted = False if doubts else None if undecided else True
    return found | {"trusted": trusted, "reasons": doubts or undecided}


def _told(c: Comparison) -> dict[str, Any]:
    speed, amplitude = (x if math.isfinite(x) else None for x in c.largest)
    return {
        "speed": speed,
        "amplitude": amplitude,
        "same_outcome": c.same_outcome,
        "outcome": c.outcome,
        "slow_outcome": c.slow_outcome,
    }


def regions(compared: Sequence[Comparison]) -> list[list[float]]:
    """Ranges of the parameter, from the first to the last value of each row of values with different outcomes."""
    found: list[list[float]] = []
    before = True
    for c in compared:
        if c.same_outcome is False:
            found = [*found[:-1], [found[-1][0], c.value]] if not before else [*found, [c.value, c.value]]
        before = c.same_outcome is not False
    return found


def _doubts(own: Comparison | None, measured: Errors | None, whose: str) -> list[str]:
    """Why the slow equations may not be trusted for the machine as it is."""
    if own is None:
        return []
    said = []
    if own.same_outcome is False:
        said.append(f"the full equations end {own.outcome}, the slow ones {own.slow_outcome}")
    whole = {f"the speeds of {whose}": TRUSTED, "the amplitudes": AMPLITUDE_TRUSTED}
    if math.isnan(own.relative[0]):
        said.append("they share no angle")
    said += [
        f"{what} differ by {_percent(apart)} of the largest"
        for (what, limit), apart in zip(whole.items(), own.relative, strict=True)
        if apart > limit
    ]
    if measured is not None and measured.order < LEAST_ORDER * measured.nominal:
        said.append(
            f"their error falls with epsilon to the power {measured.order:.2g}, not {measured.nominal:g}: epsilon is not small"
        )
    return said


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def _undecided(own: Comparison | None, unmeasured: str) -> list[str]:
    """Why nothing can be said."""
    if own is None:
        return ["nothing was compared"]
    said = []
    if own.same_outcome is None:
        said.append("the runs are too short to tell an outcome; give a longer study.until")
    if unmeasured:
        said.append(f"whether the error falls with epsilon could not be measured: {unmeasured}")
    return said


def sentence_of(summary: dict[str, Any]) -> str:
    """The answer in words."""
    if summary["trusted"]:
        return "the slow equations may be trusted for this machine"
    if summary["trusted"] is None:
        return f"not decided whether the slow equations may be trusted: {'; '.join(summary['reasons'])}"
    return f"the slow equations are not to be trusted for this machine: {'; '.join(summary['reasons'])}"
