"""Plan -> findings: the turning points of the signal, leg by leg of a run-up, or of a record at once."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.dynamics.run_ups.machine_signals import LoadHistory, load_histories
from wucht.dynamics.work import Work
from wucht.fatigue.turning_points import TurningPoints
from wucht.measurements.recording import Channel
from wucht.studies.load_spectrum.prepare import Plan


def run(plan: Plan, work: Work) -> Iterator[LoadHistory]:
    """The findings after each leg."""
    if isinstance(plan.signal, Channel):
        time, values = TurningPoints().after(plan.signal.time, plan.signal.values).closed()
        yield LoadHistory(time, values, float(plan.signal.time[-1]))
    elif plan.case is not None:
        yield from load_histories(plan.case, plan.signal, work)
