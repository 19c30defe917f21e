"""A run of a machine: integrated leg by leg, checked by a neighbour and with other contacts, and its answer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.long_run import LongRun
from wucht.dynamics.run_ups.contacts import check_contacts
from wucht.dynamics.run_ups.hanging_start import is_hanging_start
from wucht.dynamics.run_ups.horizon import numbers_per_sample
from wucht.dynamics.run_ups.limit_at_end import limit_at_end
from wucht.dynamics.run_ups.neighbours import neighbour_of
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.work import Work
from wucht.machines.machine import Machine
from wucht.results.quantities import Quantity
from wucht.studies.answer import Answer
from wucht.studies.limit_set_variables import state_machine_limit_set
from wucht.studies.run_up.answer import fill_run
from wucht.studies.run_up.combined_runs import Fill, Run, end_in_words, printed_number, state_cases, variables_of_cases
from wucht.studies.run_up.figure import mean_phase, rotor_angle

_SHARE_BESIDE_CONTACTS = 0.4  # of the work in a run, where it may be made again with stiffer contacts
_MOST_SAMPLES = 20_000  # of each of many runs
_VARIABLES_OF_CASES = (
    "speed", "amplitude", "phase", "energy_residual", "slow_speed", "slow_amplitude", "abscissa", "slow_abscissa", "time",
)  # fmt: skip
_SLOW = "  averaged equations"


@dataclass(frozen=True)
class MachineRun(Run):
    """A run of a machine. over, deck, limit_set: as the keys of the study."""

    case: RunUpCase
    over: str
    deck: float | None
    limit_set: bool

    @property
    def stored_numbers(self) -> float:
        """See ``Run``."""
        return self.case.horizon.samples * len(self.case.models) * numbers_per_sample(self.case.machine)

    def follow(self, work: Work) -> Iterator[tuple[Fill, bool]]:
        """See ``Run``."""
        motions: tuple[Motion, ...] = ()
        hangs = is_hanging_start(self.case.machine, self.start)
        share = _SHARE_BESIDE_CONTACTS if self.case.machine.tracks else 1.0
        for motions in run_up(self.case, work.part("", 0.0, share)):
            yield partial(fill_run, motions, None, None, self.deck, hangs), False
        check = check_contacts(motions[0], work.part("contacts", share, 1.0))
        if check is not None and check.is_stiffer:
            motions = (check.motion, *motions[1:])
        neighbour = neighbour_of(motions[0], work.part("neighbour", 1.0, 1.0))
        fill = partial(fill_run, motions, neighbour, check, self.deck, hangs)
        if self.limit_set and motions[0].trajectory.failure is None:
            yield fill, False
            report = partial(_tell_time, work.part("", 1.0, 1.0))
            limit = work.unit("limit set", partial(limit_at_end, motions[0], report))
            fill = partial(_fill_with_limit_set, fill, limit, self.case.machine)
        yield fill, True

    def state_many(
        self, a: Answer, along: str | None, runs: Sequence[Run], results: Sequence[Answer], finished_count: int
    ) -> None:
        """State the runs over time, sampled no more densely than a figure needs, and a line for each."""
        state_cases(a, along, runs, results, finished_count, {})
        summaries = [r.summary for r in results]
        a.verdict = ", ".join(f"{n} {outcome}" for outcome, n in Counter(s["outcome"] for s in summaries).items())
        names = [name for c, s in zip(runs, summaries, strict=False) for name in (c.label, _SLOW if "slow" in s else "")]
        width = max(map(len, names))
        for run, s in zip(runs, summaries, strict=False):
            a.line(f"{run.label:{width}}  {s['outcome']:20} {end_in_words(a, s)}", "")
            if "slow" in s:
                deviation, far = s["deviations"]["at_equal_angle"], ""
                if deviation is not None:
                    amplitude = printed_number(a, deviation["amplitude"], s["amplitude_unit"])
                    far = f"; deviation {printed_number(a, deviation['speed'], 'rad/s')}, {amplitude} at most"
                a.line(f"{_SLOW:{width}}  {s['slow']['outcome']:20} {end_in_words(a, s['slow'])}{far}", "")
        variables = [{q.name: q for q in r.quantities if q.dimensions is not None} | _abscissae(r, self.over) for r in results]
        a.add([*variables_of_cases(variables, _VARIABLES_OF_CASES, _MOST_SAMPLES), variables[0]["body"]])
        a.curve("case", [c.label for c, _ in zip(runs, results, strict=False)], "case")


def _fill_with_limit_set(fill: Fill, limit: LongRun, machine: Machine, a: Answer) -> None:
    fill(a)
    state_machine_limit_set(a, limit, machine)


def _tell_time(work: Work, time: float) -> None:
    work.report(1.0, f"what the motion tends to, followed for {time:.4g}")


def _abscissae(result: Answer, over: str) -> dict[str, Quantity]:
    """Return the abscissa of the figure for each model of a run; none where that is the time."""
    values = {q.name: np.asarray(q.value) for q in result.quantities if q.dimensions is not None}
    models = [model for model in ("", "slow_") if f"{model}angle" in values and over != "time"]
    words = "angle of the rotor" if over == "phi" else "mean phase of the bodies"

    def abscissa(angle: np.ndarray) -> np.ndarray:
        return rotor_angle(angle) if over == "phi" else mean_phase(angle, values["phase"])

    return {
        f"{model}abscissa": Quantity(f"{model}abscissa", abscissa(values[f"{model}angle"]), words, "rad", "time")
        for model in models
    }
