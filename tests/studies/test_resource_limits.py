"""Room for what is asked: refused in a sentence before anything is computed."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from time import process_time

import pytest
from tests.refusals import failed, refused

from wucht import CoastDown, Entrainment, LoadSpectrum, Machine, RunUp, load_machine, run
from wucht.extending import Study
from wucht.files.building import machine_from
from wucht.studies import resource_limits as room

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


@pytest.fixture
def room_of_12_gb() -> Iterator[None]:
    """This process may not have more."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (12_000_000_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


@pytest.mark.usefixtures("room_of_12_gb")
@pytest.mark.parametrize("question", [CoastDown(until=1e7), LoadSpectrum(until=1e7)], ids=lambda q: q.kind)
def test_a_result_larger_than_the_memory(question: Study) -> None:
    """The memory of the machine is limited as the process is."""
    with refused("study", "12 GB", given=None):
        run(question, load_machine(R1))


def test_what_is_usual_has_room_on_a_small_computer() -> None:
    for asked in (RunUp(settled=True), RunUp(until=1e4), RunUp(until=1e9)):
        assert 8 * asked.stored_numbers(asked.prepare(load_machine(R1))) < 1e9


def test_what_does_not_fit_after_all_is_a_sentence(tmp_path: Path) -> None:
    def full(_share: float, _what: str) -> None:
        raise MemoryError("Unable to allocate 2.78 TiB")

    with failed("memory", "2.78"):
        run(RunUp(until=1.0), load_machine(R1), folder=tmp_path, progress=full)


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
@pytest.mark.parametrize(("bodies", "notes"), [(38, 0), (39, 1)])
def test_what_many_bodies_take_is_said_before_it_is_spent(bodies: int, notes: int) -> None:
    """More than five seconds, of 0.12 for each coordinate of which a rotor on a carrier has three: before the checks, too."""
    said: list[str] = []

    def stop(_: float, label: str) -> None:
        said.append(label)
        raise KeyboardInterrupt

    with suppress(KeyboardInterrupt):
        run(RunUp(until=1.0), many_pendulums(bodies), announce=said.append, progress=stop)
    assert [note.endswith("in about 5 s") for note in said] == [True] * notes + [False]


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
