"""A run of a machine: integrated leg by leg, checked by a neighbour and with other contacts, and its answer."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

from wucht.dynamics.limit_sets.long_run import LongRun
from wucht.dynamics.run_ups.contacts import ContactCheck, check_contacts
from wucht.dynamics.run_ups.hanging_start import is_hanging_start
from wucht.dynamics.run_ups.horizon import numbers_per_sample
from wucht.dynamics.run_ups.limit_at_end import limit_at_end
from wucht.dynamics.run_ups.neighbours import Neighbour, neighbour_of
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES
from wucht.dynamics.work import Work
from wucht.numerics.alike_numbers import are_alike, largest_number
from wucht.plots.run_panels import ANGLES, turned_angle
from wucht.results.quantities import Quantity, group
from wucht.studies.answer import Answer
from wucht.studies.limit_set_variables import state_machine_limit_set
from wucht.studies.run_up.answer import fill_motion
from wucht.studies.run_up.combined_runs import end_in_words, state_averaged, state_cases, variables_of_cases

_SHARE_BESIDE_CONTACTS = 0.4  # of the work in a run, where it may be made again with stiffer contacts
_MOST_SAMPLES = 20_000  # of each of many runs
_VARIABLES_OF_CASES = (
    "speed", "amplitude", "phase", "energy_residual", "slow_speed", "slow_amplitude", "abscissa", "slow_abscissa", "time",
)  # fmt: skip
_SLOW = "  averaged equations"
_ONE_OF_MANY = "one_of_many"
_MOST_NAMES = 4  # in the warning
_START = "1e-6 rad"  # ``neighbours.DISPLACEMENT``
_NO_RESULTS = ("energy_residual", "damper_mismatch", "natural_frequencies", "dimensionless", "advice", "amplitude_unit")


@dataclass(frozen=True)
class MachineRun:
    """A run of a machine. start, over, deck, limit_set: as the keys of the study. value: of the parameter ``along``."""

    label: str
    start: Mapping[str, Any]
    value: float | None
    case: RunUpCase
    over: str
    deck: float | None
    limit_set: bool

    @property
    def stored_numbers(self) -> float:
        """A bound of the numbers that it stores."""
        return self.case.horizon.samples * len(self.case.models) * numbers_per_sample(self.case.machine)

    @cached_property
    def hangs(self) -> bool:
        """True if it starts at rest, hanging."""
        return is_hanging_start(self.case.machine, self.start)

    def answers(self, work: Work) -> Iterator[Answer]:
        """Integrate it, and yield its answer whenever more of it is known."""
        share = _SHARE_BESIDE_CONTACTS if self.case.machine.tracks else 1.0
        for motions in run_up(self.case, work.part("", 0.0, share)):
            yield self._answer(motions)
        check = check_contacts(motions[0], work.part("contacts", share, 1.0))
        if check is not None and check.is_stiffer:
            motions = (check.motion, *motions[1:])
        neighbour = neighbour_of(motions[0], work.part("neighbour", 1.0, 1.0))
        yield self._answer(motions, neighbour, check)
        if self.limit_set and motions[0].trajectory.failure is None:
            report = partial(_tell_time, work.part("", 1.0, 1.0))
            limit = work.unit("limit set", partial(limit_at_end, motions[0], report))
            yield self._answer(motions, neighbour, check, limit)

    def _answer(
        self,
        motions: tuple[Motion, ...],
        neighbour: Neighbour | None = None,
        check: ContactCheck | None = None,
        limit: LongRun | None = None,
    ) -> Answer:
        """Return what is known of the motions of all models. neighbour, check, limit: of the first."""
        units = self.case.machine.units

        def fill(chance: Collection[str], a: Answer) -> None:
            fill_motion(motions[0], self.deck, self.hangs, a, check, chance)
            for motion in motions[1:]:
                state_averaged(a, motions, Answer(units, partial(fill_motion, motion, self.deck, self.hangs)).fill())

        def fill_all(a: Answer) -> None:
            if neighbour is None:
                fill((), a)
            else:
                run = Answer(units, partial(fill, ())).fill()
                beside = Answer(units, partial(fill_motion, neighbour.motion, self.deck, self.hangs)).fill()
                differing = _differing_numbers(run, beside)
                fill([q.name for q in differing], a)
                _state_chance(a, differing, run.summary["outcome"], beside.summary["outcome"], neighbour.growth)
            if limit is not None:
                state_machine_limit_set(a, limit, self.case.machine)

        return Answer(units, fill_all)

    def state_many(
        self, along: str | None, runs: Sequence[Any], answers: Sequence[Answer], finished_count: int, a: Answer
    ) -> None:
        """State many runs over time, sampled no more densely than a figure needs, and a line for each.

        There may be fewer answers than runs. finished_count: how many are complete.
        """
        results = [answer.fill() for answer in answers]
        state_cases(a, along, runs, results, finished_count)
        labels, summaries = [run.label for run in runs[: len(results)]], [r.summary for r in results]
        a.verdict = ", ".join(f"{n} {outcome}" for outcome, n in Counter(s["outcome"] for s in summaries).items())
        width = max(len(name) for name in (*labels, *(_SLOW for s in summaries if "slow" in s)))
        for label, s in zip(labels, summaries, strict=True):
            a.line(f"{label:{width}}  {s['outcome']:20} {end_in_words(a, s)}", "")
            if "slow" in s:
                deviation, far = s["deviations"]["at_equal_angle"], ""
                if deviation is not None:
                    amplitude = a.number_in_words(deviation["amplitude"], s["amplitude_unit"])
                    far = f"; deviation {a.number_in_words(deviation['speed'], 'speed')}, {amplitude} at most"
                a.line(f"{_SLOW:{width}}  {s['slow']['outcome']:20} {end_in_words(a, s['slow'])}{far}", "")
        variables = [{q.name: q for q in r.quantities if q.dimensions is not None} | _abscissae(r, self.over) for r in results]
        a.add([*variables_of_cases(variables, _VARIABLES_OF_CASES, _MOST_SAMPLES), variables[0]["body"]])
        a.curve("case", labels, "case")


def _tell_time(work: Work, time: float) -> None:
    work.report(1.0, f"what the motion tends to, followed for {time:.4g}")


def _abscissae(result: Answer, over: str) -> dict[str, Quantity]:
    """Return the abscissa of the figure for each model of a run; none where that is the time."""
    row = {q.name: q.value for q in result.quantities if q.dimensions is not None}
    names = {f"{model}abscissa": model for model in ("", "slow_") if f"{model}angle" in row and over != "time"}
    return {
        name: Quantity(name, turned_angle(over, row, model), ANGLES[over][0], "rad", "time") for name, model in names.items()
    }


def _differing_numbers(run_result: Answer, neighbour: Answer) -> list[Quantity]:
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


def _state_chance(a: Answer, differing: Sequence[Quantity], outcome: str, of_neighbour: str, growth: float) -> None:
    """State the numbers of a neighbouring run that differ. outcome, of_neighbour: of both. growth: of their difference."""
    if not differing:
        return
    names, more = ", ".join(q.long_name for q in differing[:_MOST_NAMES]), len(differing) - _MOST_NAMES
    count = "1 number is" if len(differing) == 1 else f"{len(differing)} numbers are"
    warning = (
        f"the run amplifies differences 1e{math.floor(math.log10(growth))} times, and {count} one draw of many ({names}"
        f"{f' and {more} more' if more > 0 else ''}): a start {_START} away gives those in {_ONE_OF_MANY}, several "
        "starts show their spread; all other numbers hold"
    )
    if "outcome" in {q.name for q in differing}:
        warning = f"the outcome is chance: a start {_START} away ends as {of_neighbour}; {warning}"
    elif outcome in OPEN_OUTCOMES and of_neighbour not in OPEN_OUTCOMES:
        warning = f"a start {_START} away ends as {of_neighbour}; {warning}"
    a.warn(warning)
    a.add([group(_ONE_OF_MANY, differing, f"numbers that are chance, from a start {_START} away")])
