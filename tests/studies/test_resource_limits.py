"""Room for what is asked: refused in a sentence before anything is computed."""

from __future__ import annotations

import resource
from contextlib import suppress
from pathlib import Path
from time import process_time

import pytest
from tests.refusals import failed, refused

from wucht import CoastDown, Entrainment, LoadSpectrum, Machine, RunUp, load_machine, run
from wucht.dynamics.entrainment import runs_from_start as runs
from wucht.files.building import machine_from
from wucht.studies import resource_limits as room
from wucht.studies import runner
from wucht.studies.study import Study

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
def test_a_run_that_would_never_be_over(question: Study, name: str) -> None:
    with refused("study.until", "turns", "1e+09", given=question.until) as caught:
        run(question, load_machine(name))
    longest = float(caught.value.explanation.split("must be at most ")[1].split()[0].rstrip(":"))
    assert 1e5 < longest < 1e10


def test_vibrations_that_would_never_be_over() -> None:
    """They take steps even where they have decayed, but for an implicit method and for averaged equations."""
    stiff = load_machine(R1, {"carrier.stiffness": 1e29})
    with refused("study.until", "05 s", given=0.5):
        room.refuse_turns(RunUp(until=0.5), stiff)
    for asked in (RunUp(until=0.5, engine="radau"), RunUp(until=0.5, model="slow"), RunUp(until=1e-5)):
        room.refuse_turns(asked, stiff)


@pytest.mark.parametrize(
    "question", [RunUp(until=2e6), RunUp(settled=True), CoastDown(until=2e6), LoadSpectrum(until=2e6)], ids=lambda q: q.kind
)
def test_a_result_larger_than_the_memory(question: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "machine_memory", lambda: 1e7)
    with refused("study", "0.01 GB", given=None):
        run(question, load_machine(R1))


def test_what_is_usual_has_room_on_a_small_computer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "machine_memory", lambda: 4e9)
    for asked in (RunUp(settled=True), RunUp(until=1e4)):
        room.refuse_numbers(asked.stored_numbers(asked.prepare(load_machine(R1))))


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
        plan = Entrainment(until=3000.0).prepare(load_machine(BAND))
        return runs.RunsFromStart(plan)(plan.parameter.nominal_value, lambda _: None)

    whole = end()
    monkeypatch.setattr(runs, "_AT_ONCE", 2)
    parts = end()
    assert parts.end_time == whole.end_time == 3000.0
    assert parts.is_entrained
    assert parts.end_state == pytest.approx(whole.end_state, rel=1e-6, abs=1e-9)
    assert parts.phases == pytest.approx(whole.phases, abs=1e-9)


@pytest.mark.parametrize(
    ("count", "says"), [(41, None), (42, "the equations of 42 coordinates are derived and compiled first")]
)
def test_what_many_bodies_take_is_said_before_it_is_spent(
    count: int, says: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """More than five seconds, of 0.12 for each coordinate."""
    machine = load_machine(R1)
    monkeypatch.setattr(type(machine), "coordinates", property(lambda _: (None,) * count), raising=False)
    note = room.equations_note(machine)
    assert note is None if says is None else note is not None and note.startswith(says) and note.endswith("in about 5 s")
    assert room.equations_note("no machine") is None


def test_the_runner_announces_it_before_all_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also before the checks, which take seconds with so many bodies, and before the machine is described."""
    done: list[str] = []
    for name in ("subject_of", "refuse_turns", "refuse_numbers"):
        original = getattr(runner, name)
        monkeypatch.setattr(runner, name, lambda *args, name=name, original=original: done.append(name) or original(*args))
    monkeypatch.setattr(runner, "equations_note", lambda _: "its equations take long")
    run(RunUp(until=1.0), load_machine(R1), announce=done.append)
    assert done == ["its equations take long", "subject_of", "refuse_turns", "refuse_numbers"]


def many_pendulums(count: int) -> Machine:
    """A rotor with pendulums, whose structure no other test has."""
    carrier = {"mass": 1.0, "directions": "xy", "stiffness": 4000.0, "damping": 10.0}
    rotor = {"kind": "rotor", "name": "drum", "mass": 0.5, "unbalance": 2e-4, "inertia": 0.02}
    pendulum = {"kind": "pendulum", "about": "drum", "mass": 2e-4, "length": 0.03, "damping": 1e-7}
    bodies = [rotor, *({**pendulum, "name": f"p{k}", "start": 6.0 * k / count} for k in range(count))]
    return machine_from(
        {"carrier": carrier, "bodies": bodies, "drive": {"kind": "linear", "slope": 5e-3, "no_load_speed": 200.0}}
    )


@pytest.mark.slow
@pytest.mark.parametrize("count", [40, 100])
def test_the_announced_time_is_that_of_the_work(count: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Within a factor of 3, in time of the processor, from the announcement to the end of the first leg of the run."""
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path))
    announced: list[tuple[float, float]] = []

    def announce(note: str) -> None:
        announced.append((float(note.rpartition("about ")[2].removesuffix(" s")), process_time()))

    def stop(_: float, label: str) -> None:
        if label != "preparation":
            raise KeyboardInterrupt

    with suppress(KeyboardInterrupt):
        run(RunUp(until=1.0), many_pendulums(count), announce=announce, progress=stop)
    ((seconds, begin),) = announced
    assert seconds / 3 <= process_time() - begin <= 3 * seconds
