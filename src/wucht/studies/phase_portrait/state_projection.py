"""A portrait of equations of more than two states, projected on two."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.equilibria_in_ranges import (
    SEARCHES,
    distinct_limit_sets,
    equilibria_in_ranges,
    equilibrium_kind,
)
from wucht.dynamics.limit_sets.long_run import LongRun, long_run
from wucht.dynamics.work import Work
from wucht.machines.subject import Subject
from wucht.studies.answer import Answer
from wucht.studies.phase_portrait.answer import padded_items

_MOST_SAMPLES = 4000  # of a trajectory, and of what it tends to


@dataclass(frozen=True, eq=False)
class StateProjection:
    """Two states, by their rows; the lowest and the highest value (n,) of all states; and starts (n, k) of trajectories."""

    rows: tuple[int, int]
    low: np.ndarray
    high: np.ndarray
    starts: np.ndarray


def project_states(subject: Subject, projection: StateProjection, work: Work) -> Iterator[Answer]:
    """Yield the answer after each trajectory."""
    search = partial(equilibria_in_ranges, subject.system, subject.values, projection.low, projection.high)
    equilibria, eigenvalues = work.unit("equilibria", search)
    runs = list[LongRun]()
    for k, start in enumerate(projection.starts.T):
        work.report(k / projection.starts.shape[1], "trajectories")
        runs.append(work.unit(f"trajectory {k + 1}", partial(long_run, subject, start)))
        yield _answer(subject, projection, equilibria, eigenvalues, runs)
    if not runs:
        yield _answer(subject, projection, equilibria, eigenvalues, runs)


def _answer(
    subject: Subject,
    projection: StateProjection,
    equilibria: np.ndarray,
    eigenvalues: Sequence[np.ndarray],
    runs: Sequence[LongRun],
) -> Answer:
    """equilibria: (n, e), with their eigenvalues. runs: the trajectories."""
    a, rows, names = Answer(), projection.rows, subject.system.state_names
    turning = list(map(int, subject.system.is_angle))
    a.attribute(abscissa=rows[0], ordinate=rows[1], turning=turning, subject="system")
    a.assume(f"equilibria are those to which Newton's method leads from {SEARCHES} starts in the ranges: there may be more")
    kinds, sets = [equilibrium_kind(e) for e in eigenvalues], distinct_limit_sets(runs)
    states = [dict(zip(names, x.tolist(), strict=True)) for x in equilibria.T]
    a.table(
        "fixed_points", "equilibria",
        state=(states, "states"),
        kind=(kinds, "kind"),
        stable=([kind == "stable" for kind in kinds], "whether nearby motions tend to it"),
        eigenvalues=([[[float(v.real), float(v.imag)] for v in e] for e in eigenvalues], "eigenvalues"),
    )  # fmt: skip
    for state, kind in zip(states, kinds, strict=True):
        a.line(kind, ", ".join(f"{name} {value:.7g}" for name, value in state.items()))
    sentences = [sentence_of(one.kind, one, names) for one in sets]
    attractors = [
        {"kind": str(one.kind), "sentence": sentence, **numbers_of(one, names)}
        for one, sentence in zip(sets, sentences, strict=True)
    ]
    parts = {"state": ("states", ""), "kind": ("kind", ""), "stable": ("whether nearby motions tend to it", "")}
    a.number("attractors", attractors, "what the trajectories tend to", parts=parts | {"sentence": ("what it is", "")})
    for sentence in sentences:
        a.line("attractor", "{sentence}", sentence=sentence)
    a.curve("state", list(names), "state")
    a.curve("equilibria", equilibria, "equilibrium", "", "state equilibrium")
    a.curve("equilibrium_kind", np.array(kinds, "U16"), "kind", "", "equilibrium")
    trajectories = padded_items([[r.settling_states(_MOST_SAMPLES) for r in runs]], (len(names), -1))[0]
    a.curve("trajectories", trajectories, "trajectory", "", "trajectory state sample")
    curves = padded_items([[one.samples(_MOST_SAMPLES)[1] for one in sets]], (len(names), -1))[0]
    a.curve("limit_sets", curves, "state on what trajectories tend to", "", "limit_set state place")
    a.curve("limit_set_kind", np.array([str(one.kind) for one in sets], "U16"), "kind", "", "limit_set")
    a.curve("drawn", np.stack([projection.low, projection.high], axis=1), "range of the state", "", "state end")
    counts = [f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds)]
    set_kinds = [one.kind for one in sets]
    ends = [f"{set_kinds.count(kind)} {kind}" for kind in dict.fromkeys(set_kinds)]
    a.sentence = f"equilibria: {', '.join(counts) or 'none'}; trajectories tend to: {', '.join(ends) or 'nothing known'}"
    return a
