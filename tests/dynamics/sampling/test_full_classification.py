"""How densely members are sampled that turn faster than the machine of the question, and their outcomes in order."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.sampling import full_classification as module
from wucht.dynamics.sampling.full_classification import (
    ClassifyingObserver,
    ObserverState,
    _doublings,
    begins_fast,
    classify_members,
)
from wucht.dynamics.sampling.screening_observer import DoublingSchedule
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.numerics.ensembles.members import Chunk, Pace, Status


def horizon(monkeypatch: pytest.MonkeyPatch, free: dict[str, float | None], starts: list[float]) -> Any:
    """Up to 100 rad/s are sampled densely enough."""
    monkeypatch.setattr(module, "_sampled_speed", lambda _: 100.0)
    monkeypatch.setattr(module, "free_speed", lambda machine, rotor, time: free[rotor])
    monkeypatch.setattr(module, "fastest_speeds", lambda machine, given: np.array(starts))
    machines = tuple(SimpleNamespace(rotors=names, breakpoints=(0.0,)) for names in (("a", "b"), ("c",)))
    for machine in machines:
        machine.at = lambda time, machine=machine: machine
    return SimpleNamespace(machines=machines, machine_index=np.array([0, 0, 1, 1]))


def test_doublings_of_the_sampling_density(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the fastest motor, whichever way it turns, or by the start."""
    variants = horizon(monkeypatch, {"a": 90.0, "b": -250.0, "c": None}, [50.0, 500.0, 99.0, 201.0])
    assert _doublings(np.zeros((1, 4)), variants, None).tolist() == [2, 3, 0, 2]  # type: ignore[arg-type]
    assert begins_fast(np.zeros((1, 4)), None, None).tolist() == [False, True, False, True]  # type: ignore[arg-type]
    variants = horizon(monkeypatch, {"a": 90.0, "b": 20.0, "c": 200.0}, [1.0] * 4)
    assert _doublings(np.zeros((1, 4)), variants, None).tolist() == [0, 0, 1, 1]  # type: ignore[arg-type]


def test_members_keep_their_order_and_are_sampled_as_they_need(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_doublings", lambda *_: np.array([1, 0, 2, 0, 1]))
    monkeypatch.setattr(module, "replace", lambda of, **keys: SimpleNamespace(**vars(of) | keys))
    asked = list[tuple[Any, ...]]()

    def observe(question: Any, starts: np.ndarray, variants: Any, horizon: Any, report: Any) -> Any:
        asked.append((starts[0].tolist(), variants, horizon.step, horizon.span, question.longest))
        report(0.5)
        for half in np.array_split(starts[0], 2):
            observations = [SimpleNamespace(largest=10 * x) for x in half]
            record = SimpleNamespace(outcome=half.astype(int), settling_time=half + 0.5, observations=observations)
            status = np.array([Status.FAILED if x == 4 else Status.SETTLED for x in half])
            sentences = {i: "burst" for i, x in enumerate(half) if x == 4}
            yield SimpleNamespace(status=status, record=record, times=half + 100, sentences=sentences)

    monkeypatch.setattr(module, "observe_members", observe)
    variants: Any = SimpleNamespace(select=lambda members: SimpleNamespace(compact=members.tolist()))
    reported = list[float]()
    made = classify_members(
        SimpleNamespace(longest=8),
        np.arange(5.0)[None],
        variants,
        SimpleNamespace(step=0.4, span=6.0),
        reported.append,  # type: ignore[arg-type]
    )
    assert asked == [([1.0, 3.0], [1, 3], 0.4, 6.0, 8), ([0.0, 4.0], [0, 4], 0.2, 3.0, 16), ([2.0], [2], 0.1, 1.5, 32)]
    assert made.outcome.tolist() == [0, 1, 2, 3, OUTCOMES.index(Outcome.FAILED)] and made.failures == ((4, "burst"),)
    assert made.settling_time == pytest.approx(np.arange(5.0) + 0.5) and made.end_time == pytest.approx(np.arange(100.0, 105.0))
    assert made.peak_amplitude == pytest.approx(10 * np.arange(5.0))
    assert reported == pytest.approx([0.2, 0.6, 0.9])


@pytest.mark.parametrize(("end", "chunks"), [(300.0, 1), (301.0, 2), (1200.0, 3), (100.0, 1)])
def test_a_schedule_has_a_first_chunk_of_at_most_the_given_length(end: float, chunks: int) -> None:
    of = DoublingSchedule.from_end(end, 300.0)
    assert (of.chunks, of.end, of.first) == (chunks, end, end / 2 ** (chunks - 1)) and of.first <= 300.0


def test_each_member_is_judged_as_a_motion_of_its_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """By its number, whatever its place among those that still run: member 3 has machine b, member 0 machine a."""
    outcomes = {"a": Outcome.COMPENSATED, "b": Outcome.STOPPED}

    def judged(model: Any, observation: str, state: np.ndarray) -> Any:
        name = model.machine.name
        assert state.tolist() == [30.0 if observation == "three" else 0.0]  # its own, the last one
        settling = float(len(observation)) if name == "a" else None
        return SimpleNamespace(
            outcome=outcomes[name], settling_time=settling, settled_within=lambda _: False, never_parts=False
        )

    monkeypatch.setattr(module, "member_verdict", judged)
    monkeypatch.setattr(ClassifyingObserver, "_observe", lambda _, record, times, samples: record.observations)
    machines = [SimpleNamespace(name=name) for name in ("a", "b")]
    models: Any = tuple(SimpleNamespace(machine=m) for m in machines)
    observer = ClassifyingObserver(models, np.array([0, 1, 0, 1]), 1.0, None, Pace(2.0, 4, 2.0), True)  # type: ignore[arg-type]
    numbers, none = np.array([3, 0]), np.full(2, np.nan)
    record = ObserverState(numbers, np.array(["three", "zero"], object), np.zeros(2, np.int8), none)
    samples = np.array([[[1.0, 2.0]], [[30.0, 0.0]]])
    later, has_ended = observer.update(record, Chunk(np.array([1.0, 2.0]), samples, np.zeros((0, 2))))
    assert [OUTCOMES[k] for k in later.outcome] == [Outcome.STOPPED, Outcome.COMPENSATED]
    assert later.settling_time.tolist() == pytest.approx([np.nan, 4.0], nan_ok=True) and has_ended.tolist() == [True, False]
