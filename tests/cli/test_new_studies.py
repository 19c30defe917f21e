"""All studies from the command line: their questions spoilt, their templates run, interrupted, resumed and drawn."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from wucht.cli.progress import Progress

Refused = Callable[..., str]
Command = Callable[..., Any]
Study = Callable[..., Path]

STUDIES = (
    "run-up", "coast-down", "start-stop", "drive-failure", "sweep", "response", "torque-balance", "entrainment",
    "approximation",
)  # fmt: skip
# Their templates: long ones, and those that tests/studies runs too.
LONG = ("approximation", "sweep", "entrainment", "coast-down", "start-stop", "drive-failure", "response", "torque-balance")

QUESTIONS: dict[str, dict[str, tuple[str, ...]]] = {
    "response": {
        "range=[1]": ("study.range", "pair [low, high]"),
        "range=[3,1]": ("study.range", "low below high"),
        "range=[1,1]": ("study.range", "low below high"),
        "range=[-1,3]": ("study.range", "at least 0"),
        'range=["1 kg","2 kg"]': ("study.range[0]", "this one is a mass"),
        "points=1": ("study.points", "whole number from 2"),
        "points=1.5": ("study.points", "whole number"),
        "points=1e9": ("study.points", "100000"),
        "start.p1=3": ("study.start.p1", "known: carrier, drum"),
        "on=drum": ("study.on", "unknown key"),
        "rang=3": ("study.rang", "did you mean 'range'?"),
    },
    "torque-balance": {
        "range=[3,1]": ("study.range", "low below high"),
        "on=dram": ("study.on", "given 'dram'", "fan"),
        'on=["fan"]': ("study.on", "must be a rotor"),
        "points=0": ("study.points", "whole number"),
    },
    "sweep": {
        "along=drive.slop": ("study.along", "did you mean 'drive.slope'?"),
        "along=drum.name": ("study.along", "unknown parameter"),
        "range=[160,80]": ("study.range", "low below high"),
        'range=["80 kg","90 kg"]': ("study.range[0]", "this one is a mass"),
        "rate=0": ("study.rate", "greater than 0"),
        "rate=1 kg": ("study.rate", "this one is a mass"),
        "direction=sideways": ("study.direction", "'both', 'up' or 'down'"),
        "jump_tolerance=1": ("study.jump_tolerance", "between"),
        "tolerance=1": ("study.tolerance", "between"),
        "engine=x": ("study.engine", "'compiled' or 'radau'"),
        "until=3": ("study.until", "unknown key"),
    },
    "coast-down": {
        "until=0": ("study.until", "greater than 0"),
        "until=1 kg": ("study.until", "this one is a mass"),
        "start.drum.speed=0": ("study.start", "nothing turns"),
        "start=3": ("study.start", "must be a table"),
        "engine=radaw": ("study.engine", "'radau'"),
        "turns=3": ("study.turns", "unknown key"),
    },
    "voltage-dip": {
        "depth=0": ("study.depth", "greater than 0"),
        "depth=1.5": ("study.depth", "at most 1"),
        "depth=92 V": ("study.depth", "given '92 V'"),
        "duration=0": ("study.duration", "greater than 0"),
        "duration=1 kg": ("study.duration", "this one is a mass"),
        "duration=[2,1]": ("study.duration", "the shortest first"),
        "duration=[1]": ("study.duration", "a pair [shortest, longest]"),
        "duration=1e7": ("study.duration", "must be at most"),
        "on=drun": ("study.on", "must be a body with a drive: drum"),
        "points=0": ("study.points", "from 1 to 200"),
        "start.drun=1": ("study.start.drun", "did you mean 'drum'?"),
        "tolerance=1": ("study.tolerance", "between"),
        "until=3": ("study.until", "unknown key"),
        "dept=1": ("study.dept", "did you mean 'depth'?"),
    },
    "start-stop": {
        "until=0": ("study.until", "greater than 0"),
        "target_life=1 kg": ("study.target_life", "this one is a mass"),
        "signal=stress": ("study.signal", "'spring-force'"),
        "woehler.SD=1 mm": ("study.woehler.SD", "this one is a length"),
        "turns=3": ("study.turns", "unknown key"),
    },
    "drive-failure": {
        "time=0": ("study.time", "greater than 0"),
        "until=1 kg": ("study.until", "this one is a mass"),
        "begin=running": ("study.begin", "'operation' or 'rest'"),
        "turns=3": ("study.turns", "unknown key"),
    },
    "run-up": {
        "over=phii": ("study.over", "'time', 'phi' or 'psi'"),
        "along=drive.slope": ("study.values", "belong together"),
        "values=[1]": ("study.along", "belong together"),
        "starts=3": ("study.starts", "list of tables"),
        "settled=false": ("study.settled", "given False"),
        "model=averaged": ("study.model", "'full', 'slow' or 'both'"),
        "order=2": ("study.order", "only with model"),
        "inertia=false": ("study.inertia", "only with model"),
    },
    "approximation": {
        "along=carrier.dampin": ("study.along", "did you mean 'carrier.damping'?"),
        "along=[]": ("study.along", "the path of a parameter, or a list"),
        "range=[1]": ("study.range", "pair [low, high]"),
        "range=[400, 50]": ("study.range", "low below high"),
        'range=["1 kg", "2 kg"]': ("study.range[0]", "this one is a mass"),
        "values=[50]": ("study.values", "either values, or range"),
        "points=1": ("study.points", "whole number from 2 to 200"),
        "spacing=log10": ("study.spacing", "must be 'linear' or 'log'"),
        "until_phi=-1": ("study.until_phi", "greater than 0"),
        "until_phi=1 kg": ("study.until_phi", "this one is a mass"),
        "until=1 kg": ("study.until", "this one is a mass"),
        "order=3": ("study.order", "must be 1 or 2"),
        "inertia=maybe": ("study.inertia", "true or false"),
        "model=both": ("study.model", "unknown key"),
        "turns=3": ("study.turns", "unknown key"),
        "tolerance=1": ("study.tolerance", "between"),
        "start.p3=1": ("study.start.p3", "did you mean"),
    },
}
CASES = [(kind, setting, says) for kind, cases in QUESTIONS.items() for setting, says in cases.items()]


@pytest.mark.parametrize(("kind", "setting", "says"), CASES, ids=[f"{kind}: {setting}" for kind, setting, _ in CASES])
def test_a_wrong_question(refused: Refused, wucht: Command, here: Path, kind: str, setting: str, says: tuple[str, ...]) -> None:
    assert wucht("new", kind, "my.toml").code == 0
    refused("run", "my.toml", "-o", "out", "--json", "--set", f"study.{setting}", says=("my.toml: ", *says))
    assert not Path("out").exists()


SWEPT = {
    "mass": ("drum.mass", "[0, 10]", "study.range[0]"),
    "inertia": ("drum.inertia", "[1e-7, 1]", "at least m e^2"),
    "eccentricity": ("drum.eccentricity", "[0, 1]", "at least m e^2"),
}


@pytest.mark.parametrize(("path", "span", "says"), SWEPT.values(), ids=SWEPT.keys())
def test_a_sweep_through_what_cannot_be(refused: Refused, wucht: Command, here: Path, path: str, span: str, says: str) -> None:
    wucht("new", "sweep", "my.toml")
    refused("run", "my.toml", "--set", f"study.along={path}", "--set", f"study.range={span}", says=("my.toml: ", says))


def test_a_schedule_beside_a_sweep(refused: Refused, study: Study) -> None:
    file = study(
        "[study]", '[[machine.schedules]]\nparameter = "drum.mass"\npoints = [[0, 9], [1, 8]]\n[study]',
        'kind = "run-up"\nuntil = "0.5 s"', 'kind = "sweep"\nalong = "drive.slope"\nrange = [0.04, 0.05]',
    )  # fmt: skip
    refused("run", file, says=("study.toml: machine.schedules", "not allowed in a sweep"))


FAST = {
    "run-up": ("study.until=0.2",),
    "coast-down": ("study.until=0.5",),
    "start-stop": ("study.until=0.5",),
    "drive-failure": ("study.time=0.5", "study.until=0.5"),
    "sweep": ("study.range=[80, 82]", "study.direction=up", "study.rate=2"),
    "approximation": ("study.until=0.3", "study.points=2"),
    "entrainment": ("study.resolution=0.2", "study.until=3"),
}


def _settings(kind: str) -> list[str]:
    return [word for setting in FAST.get(kind, ()) for word in ("--set", setting)]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", [pytest.param(k, marks=pytest.mark.slow) if k in LONG else k for k in STUDIES])
def test_a_template_runs_and_is_drawn_again(wucht: Command, here: Path, kind: str) -> None:
    assert wucht("new", kind).code == 0
    words = ("run", f"{kind}.toml", "-o", "out", "--json", *_settings(kind))
    completed = wucht(*words)
    assert completed.code == 0, completed.err
    assert completed.document["study"] == kind
    assert sorted(p.name for p in Path("out").iterdir()) == sorted([f"{kind}.png", "result.nc", "summary.json"])
    assert json.loads(Path("out/summary.json").read_text()) == completed.document
    assert xr.load_dataset("out/result.nc", engine="h5netcdf").attrs["finished"] == 1
    for extension in ("pdf", "svg"):
        assert wucht("plot", "out/result.nc", "--format", extension).code == 0
        assert Path(f"out/{kind}.{extension}").stat().st_size > 1000
    again = wucht(*words, "--resume")
    assert again.code == 0, again.err
    assert again.document["summary"] == completed.document["summary"]


@pytest.mark.parametrize("kind", STUDIES)
def test_a_folder_that_cannot_be_written(wucht: Command, here: Path, kind: str) -> None:
    wucht("new", kind)
    Path("out").write_text("a file, no folder")
    for folder in ("out", "out/below"):
        completed = wucht("run", f"{kind}.toml", "-o", folder, "--json")
        assert completed.code == 2
        assert completed.document["exit_code"] == completed.code
        assert completed.err.count("\n") == 1
        assert "out" in completed.err


@pytest.fixture
def interrupted(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """``interrupted(3)``: the third report of progress, after a share of the whole, is answered with Ctrl-C."""
    before = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)}

    def arm(count: int, share: float = 0.0) -> None:
        calls = iter(range(1, 10**9))

        def update(_self: Progress, done: float, _what: str) -> None:
            if done >= share and next(calls) == count:
                signal.raise_signal(signal.SIGINT)

        monkeypatch.setattr(Progress, "update", update)

    yield arm
    for number, handler in before.items():
        signal.signal(number, handler)


LONG = {
    "run-up": ("study.until=100",),
    "many": ("study.until=0.1", "study.along=drive.slope", "study.values=[0.03, 0.04, 0.05]"),
    "coast-down": ("study.until=100",),
    "start-stop": ("study.until=100",),
    "drive-failure": ("study.until=100",),
    "sweep": ("study.rate=2",),
    "approximation": ("study.until=0.2",),
}


# One long run is interrupted in test_interrupt.py.
@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in ("run-up", "approximation", "drive-failure") else n for n in LONG]
)
def test_ctrl_c_leaves_a_valid_result(wucht: Command, here: Path, interrupted: Callable[..., None], name: str) -> None:
    kind = "run-up" if name == "many" else name
    wucht("new", kind, "my.toml")
    settings = [word for setting in LONG[name] for word in ("--set", setting)]
    interrupted(3, 0.4 if name == "many" else 0.0)
    completed = wucht("run", "my.toml", "-o", "out", "--json", *settings)
    assert completed.code == 130, completed.err
    assert "Traceback" not in completed.err
    assert any("interrupted" in warning for warning in completed.document["warnings"])
    assert xr.load_dataset("out/result.partial.nc", engine="h5netcdf").attrs["finished"] == 0
    assert wucht("plot", "out/result.partial.nc").code == 0


@pytest.mark.usefixtures("unpainted")
def test_ctrl_c_in_the_first_of_many_runs(wucht: Command, here: Path, interrupted: Callable[..., None]) -> None:
    wucht("new", "run-up", "my.toml")
    settings = [word for setting in LONG["many"] for word in ("--set", setting)]
    interrupted(2)
    completed = wucht("run", "my.toml", "-o", "out", "--json", *settings)
    assert completed.code == 130, completed.err
    assert xr.load_dataset("out/result.partial.nc", engine="h5netcdf").attrs["finished"] == 0
    assert wucht("plot", "out/result.partial.nc").code == 0
    assert wucht("run", "my.toml", "-o", "out", "--json", "--resume", *settings).code == 0


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("where", [pytest.param("values", marks=pytest.mark.slow), "starts"])
def test_many_runs_go_on_where_they_were_interrupted(
    wucht: Command, here: Path, interrupted: Callable[..., None], where: str
) -> None:
    wucht("new", "run-up", "my.toml")
    text = Path("my.toml").read_text()
    if where == "values":
        text += '\nalong = "drive.slope"\nvalues = ["0.03 N m s", "0.05 N m s"]\n'
    else:
        text = "\n".join(line for line in text.splitlines() if not line.startswith("start ="))
        text += '\nstarts = [{ p1 = "0.3 rad" }, { p1 = "-1 rad", p2 = "90 deg" }]\n'
    Path("my.toml").write_text(text)
    words = ("run", "my.toml", "--json", "--set", "study.until=0.2")
    whole = wucht(*words, "-o", "whole").document["summary"]
    slopes = [f"slope of the torque-speed curve, drive = {value} N m s" for value in (0.03, 0.05)]
    labels = slopes if where == "values" else ["p1 = 0.3 rad", "p1 = -1 rad, p2 = 90 deg"]
    assert [c["label"] for c in whole["cases"]] == labels
    interrupted(1, 0.6)
    assert wucht(*words, "-o", "out").code == 130
    assert wucht(*words, "-o", "out", "--resume").document["summary"]["cases"] == whole["cases"]


KINDS = ("response", "torque-balance")
ENTRIES = (
    pytest.param("practice/laundry-drum", marks=pytest.mark.slow),
    "practice/screen",
    "sperling-rollers/figure-8",
    "sperling-vibration/figure-7",
    "drozdetskaya-2020/r1",
)


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("name", ENTRIES)
@pytest.mark.parametrize("kind", KINDS)
def test_another_question_of_a_catalogue_file(wucht: Command, here: Path, name: str, kind: str) -> None:
    """It is answered, or refused with a sentence that says why."""
    completed = wucht("run", name, "-o", "out", "--json", "--set", f"study.kind={kind}")
    assert completed.code in (0, 2)
    if completed.code:
        assert completed.err.count("\n") == 1
        assert name in completed.err
        assert "machine." in completed.err
    else:
        assert completed.document["study"] == kind
