"""Room for what is asked: refused in a sentence before anything is computed."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest
from tests.refusals import failed, refused

from wucht.dynamics.entrainment import runs_from_start as runs
from wucht.files.catalogue import load_machine
from wucht.studies import resource_limits as room
from wucht.studies import runner
from wucht.studies.coast_down import CoastDown
from wucht.studies.entrainment.computation import prepare as prepare_entrainment
from wucht.studies.entrainment.spec import Entrainment
from wucht.studies.load_spectrum.spec import LoadSpectrum
from wucht.studies.run_up.computation import numbers, prepare
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run
from wucht.studies.spec import Spec

R1 = "drozdetskaya-2020/r1"
BAND = "sperling-vibration/entrainment-band"


@pytest.mark.parametrize(
    ("question", "name"),
    [
        (RunUp(until=1e9), R1),
        (CoastDown(until=1e9), R1),
        (LoadSpectrum(until=1e9), R1),
        (Entrainment(until=1e11), BAND),
    ],
)
def test_a_run_that_would_never_be_over(question: Spec, name: str) -> None:
    with refused("study.until", "turns", "1e+09", given=question.until) as caught:
        run(question, load_machine(name))
    longest = float(caught.value.explanation.split("must be at most ")[1].split()[0].rstrip(":"))
    assert 1e5 < longest < 1e10


def test_vibrations_that_would_never_be_over() -> None:
    """They take steps even where they have decayed, but for an implicit method and for averaged equations."""
    stiff = load_machine(R1, {"carrier.stiffness": 1e29})
    with refused("study.until", "05 s", given=0.5):
        room.refuse_turns(RunUp(until=0.5), stiff)
    for asked in (RunUp(until=0.5, engine="scipy-radau"), RunUp(until=0.5, model="slow"), RunUp(until=1e-5)):
        room.refuse_turns(asked, stiff)


@pytest.mark.parametrize(
    "question", [RunUp(until=2e6), RunUp(settled=True), CoastDown(until=2e6), LoadSpectrum(until=2e6)], ids=lambda q: q.kind
)
def test_a_result_larger_than_the_memory(question: Spec, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "machine_memory", lambda: 1e7)
    with refused("study", "0.01 GB", given=None):
        run(question, load_machine(R1))


def test_what_is_usual_has_room_on_a_small_computer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "machine_memory", lambda: 4e9)
    for asked in (RunUp(settled=True), RunUp(until=1e4)):
        room.refuse_numbers(numbers(prepare(asked, load_machine(R1))))


def test_the_memory_of_the_machine_is_limited_as_the_process_is(monkeypatch: pytest.MonkeyPatch) -> None:
    assert 1e8 < room.machine_memory() < 1e14
    monkeypatch.setattr(resource, "getrlimit", lambda _: (10**8, resource.RLIM_INFINITY))
    assert room.machine_memory() == 1e8


def test_what_does_not_fit_after_all_is_a_sentence(tmp_path: Path) -> None:
    def full(_share: float, _what: str) -> None:
        raise MemoryError("Unable to allocate 2.78 TiB")

    with failed("memory", "2.78"):
        run(RunUp(until=1.0), load_machine(R1), folder=tmp_path, progress=full)


def test_a_run_of_entrainment_is_stored_in_bounded_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    def end() -> runs.RunFromStart:
        plan = prepare_entrainment(Entrainment(until=3000.0), load_machine(BAND))
        return runs.RunsFromStart(plan)(plan.parameter.nominal_value, lambda _: None)

    whole = end()
    monkeypatch.setattr(runs, "_AT_ONCE", 2)
    parts = end()
    assert parts.end_time == whole.end_time == 3000.0
    assert parts.is_entrained
    assert parts.end_state == pytest.approx(whole.end_state, rel=1e-6, abs=1e-9)
    assert parts.phases == pytest.approx(whole.phases, abs=1e-9)


@pytest.mark.parametrize(
    ("count", "says"), [(83, None), (84, "the equations of 84 coordinates are derived and compiled first")]
)
def test_what_many_bodies_take_is_said_before_it_is_spent(
    count: int, says: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """More than five seconds, of 0.06 for each coordinate; the runner says it before anything else."""
    machine = load_machine(R1)
    monkeypatch.setattr(type(machine), "coordinates", property(lambda _: (None,) * count), raising=False)
    note = room.equations_note(machine)
    assert note is None if says is None else note is not None and note.startswith(says) and note.endswith("in about 5 s")
    assert room.equations_note("no machine") is None


def test_the_runner_announces_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "equations_note", lambda _: "its equations take long")
    said: list[str] = []
    run(RunUp(until=1.0), load_machine(R1), announce=said.append)
    assert said == ["its equations take long"]
