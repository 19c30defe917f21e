"""Plan -> findings: each run, and what is kept of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from wucht.dynamics.run_ups.run_up import run_up
from wucht.dynamics.work import Work
from wucht.machines.machine import Machine
from wucht.studies.activation.prepare import BALANCED, SWITCHABLE, Plan, Planned
from wucht.studies.motion_variables import variables

CURVE = 400  # points of the amplitude over the speed
_LIFTED, _OUT = 0.01, 0.5  # of the stroke: the mass has left the inner stop; it is open


@dataclass(frozen=True)
class Done:
    """What is kept of a run.

    peak, peak_before, peak_after: the largest amplitude of all, and before and from the first opening on (NaN where none
    opens). peak_speed: of the rotor there. opened_at: speed of each switchable pendulum as its mass leaves the inner stop, for
    the first time that it then is open; open_at_end: whether it is. orientation: the angle from the first of them to the second
    as the first of all opens, in rad. curve: speed of the rotor, and the largest amplitude about it, (2, CURVE).
    """

    outcome: str
    final_speed: float
    final_amplitude: float
    peak: float
    peak_before: float
    peak_after: float
    peak_speed: float
    opened_at: tuple[float, ...]
    open_at_end: tuple[bool, ...]
    orientation: float
    energy_residual: float
    failure: str | None
    curve: np.ndarray


@dataclass(frozen=True)
class Findings:
    """Runs by name, as far as they are done."""

    done: dict[str, Done]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Each run is a unit of work."""
    done: dict[str, Done] = {}
    yield Findings({})
    for k, planned in enumerate(plan.runs):
        part = work.part("", k / len(plan.runs), (k + 1) / len(plan.runs))
        done[planned.name] = part.unit(planned.name, partial(_one, planned, plan.pendulums, part.report))
        part.report(1.0, planned.of)
        yield Findings(dict(done))


def _one(planned: Planned, pendulums: tuple[str, ...], report: Callable[[float, str], None]) -> Done:
    case = planned.case()
    for (motion,) in run_up(case, Work()):
        report(min(motion.last.stored.end_time / case.horizon.expected_end, 1.0), planned.of)
    data = {q.name: q.value for q in variables(case.machine, motion.rows, motion.seen, motion.observation.largest)}
    speed, angle = (dict(zip(data["body"], data[key], strict=True)) for key in ("speed", "angle"))
    rotor, amplitude = np.abs(speed[case.machine.rotor.name]), np.asarray(data["amplitude"])
    stroke = _strokes(case.machine, pendulums) if planned.of in (SWITCHABLE, BALANCED) else {}
    out = {x.name: motion.rows[x.coordinate.position.name] / stroke[x.name] for x in case.machine.sliders if x.name in stroke}
    opening = {name: _opening(s) for name, s in out.items()}
    first = min((i for i in opening.values() if i is not None), default=None)
    apart = [float(angle[n][first]) for n in pendulums[:2]] if first is not None else []
    top = int(amplitude.argmax())
    return Done(
        str(motion.verdict.outcome),
        motion.verdict.speed,
        float(amplitude[-1]),
        motion.observation.largest,
        math.nan if first is None else float(amplitude[: first + 1].max()),
        math.nan if first is None else float(amplitude[first:].max()),
        float(rotor[top]),
        tuple(math.nan if (i := opening[n]) is None else float(abs(speed[n][i])) for n in pendulums if n in opening),
        tuple(bool(out[n][-1] > _OUT) for n in pendulums if n in out),
        (apart[1] - apart[0]) % (2 * math.pi) if len(apart) == 2 else math.nan,
        float(np.max(data["energy_residual"])),
        motion.trajectory.failure,
        _curve(motion.seen.time, rotor, amplitude),
    )


def _strokes(machine: Machine, pendulums: tuple[str, ...]) -> dict[str, float]:
    return {n: machine.values[f"{n}.outer_stop"] - machine.values[f"{n}.inner_stop"] for n in pendulums}


def _opening(share: np.ndarray) -> int | None:
    """The last sample at the inner stop before the mass is open for the first time. share: of the stroke (N,)."""
    is_out = share > _OUT
    if not is_out.any():
        return None
    return int(np.flatnonzero(share[: int(is_out.argmax())] <= _LIFTED).max(initial=0))


def _curve(time: np.ndarray, speed: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Speed and amplitude at the largest amplitude of successive parts of the run (2, CURVE).

    The parts are alike in the sum of how far the speed goes in them and how long they take, as shares of the whole run.
    """
    gone = np.append(0.0, np.cumsum(np.abs(np.diff(speed))))
    passed = gone / (gone[-1] or 1.0) + (time - time[0]) / ((time[-1] - time[0]) or 1.0)
    bounds = np.unique(np.searchsorted(passed, np.linspace(0.0, passed[-1], CURVE + 1)))
    at = [a + int(amplitude[a:b].argmax()) for a, b in pairwise(bounds.tolist())]
    curve = np.full((2, CURVE), math.nan)
    curve[:, : len(at)] = speed[at], amplitude[at]
    return curve
