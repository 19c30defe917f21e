"""The commands of the contract, as a user calls them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import wucht as package
from wucht.results.formatting import units_in_print
from wucht.results.output_folder import claim_folder

Command = Callable[..., Any]
Study = Callable[..., Path]
Refused = Callable[..., str]

OBJECT = {"study", "machine", "summary", "warnings", "files", "version", "elapsed_s"}
SUMMARY = {
    "outcome", "final_speed", "min_speed", "max_speed", "final_amplitude", "peak_amplitude", "final_phases", "settling_time",
    "modulation_period", "modulation_period_phi", "energy_residual",
}  # fmt: skip
ROTOR_ALONE = """\
[machine.carrier]
mass = "1 kg"
stiffness = "1e5 N/m"
damping = "200 N s/m"
[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = "9 kg"
eccentricity = "1 mm"
inertia = "0.03 kg m^2"
[machine.drive]
kind = "linear"
slope = "4 N m s"
no_load_speed = "200 rad/s"
[study]
kind = "run-up"
until = "2 s"
"""


def _no_constant(name: str) -> None:
    raise AssertionError(f"{name} is no JSON")


def _parsed(text: str) -> dict[str, Any]:
    actual = json.loads(text, parse_constant=_no_constant)
    assert isinstance(actual, dict)
    return actual


# run


@pytest.mark.usefixtures("no_figures")
def test_json_is_one_object_with_the_keys_of_the_contract(wucht: Command, study: Study) -> None:
    completed = wucht("run", study(), "-o", "out", "--json")
    assert completed.code == 0
    actual = _parsed(completed.out)
    assert actual.keys() >= OBJECT
    assert actual["study"] == "run-up"
    assert actual["machine"] == "A drum with two pendulums"
    assert actual["version"] == package.__version__
    assert isinstance(actual["elapsed_s"], float)
    assert {Path(f).name for f in actual["files"]} == {"result.nc", "run-up.png", "summary.json"}
    assert all(Path(f).stat().st_size > 0 for f in actual["files"])
    assert _parsed(Path("out/summary.json").read_text()) == actual


@pytest.mark.usefixtures("no_figures")
def test_the_summary_has_every_key_and_null_where_there_is_no_number(wucht: Command, study: Study) -> None:
    short = wucht("run", study(), "-o", "out", "--json").document["summary"]
    assert short.keys() >= SUMMARY
    assert short["outcome"] == "unidentified"
    for missing in ("settling_time", "modulation_period", "modulation_period_phi"):
        assert short[missing] is None
    for number in ("final_speed", "min_speed", "max_speed", "final_amplitude", "peak_amplitude", "energy_residual"):
        assert isinstance(short[number], float)
    done = wucht("run", study('until = "0.5 s"', "settled = true"), "-o", "out", "--json").document["summary"]
    assert done["outcome"] == "compensated"
    assert done["final_phases"].keys() == {"p1", "p2"}
    assert all(0 <= phase < 2 * 3.141592653589793 for phase in done["final_phases"].values())
    assert done["min_speed"] <= done["final_speed"] <= done["max_speed"]
    assert isinstance(done["settling_time"], float)
    assert done["energy_residual"] < 1e-9


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_the_default_folder(wucht: Command, study: Study) -> None:
    assert wucht("run", study()).code == 0
    assert Path("results/study/result.nc").is_file()
    assert wucht("run", "drozdetskaya-2020/table-3.1-carrier", "--set", "study.until=100").code == 0
    assert Path("results/drozdetskaya-2020/table-3.1-carrier/result.nc").is_file()
    assert wucht("run", "study.toml", "--set", "study.kind=response").code == 0
    assert Path("results/study/response/response.png").is_file()
    assert Path("results/study/run-up.png").is_file()


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_nothing_of_an_earlier_result_stays_but_what_is_the_users(wucht: Command, study: Study) -> None:
    file = study()
    assert wucht("run", file, "-o", "out").code == 0
    assert wucht("plot", "out/result.nc", "--format", "svg").code == 0
    assert wucht("plot", "out/result.nc", "--format", "pdf").code == 0
    Path("out/run-up.pdf").write_bytes(b"drawn over by hand")
    Path("out/my-run-up.png").write_bytes(Path("out/run-up.png").read_bytes())
    assert wucht("run", file, "-o", "out", "--set", "study.kind=response", "--set", "study.range=[300, 200]").code == 2
    assert Path("out/run-up.png").is_file(), "a question that is refused removes nothing"
    response = wucht("run", file, "-o", "out", "--set", "study.kind=response", "--json").document
    files = sorted(p.name for p in Path("out").iterdir())
    assert files == ["my-run-up.png", "response.png", "result.nc", "run-up.pdf", "summary.json"]
    assert json.loads(Path("out/summary.json").read_text("utf-8")) == response


@pytest.mark.usefixtures("no_figures")
def test_a_second_run_into_one_folder_is_refused(wucht: Command, study: Study) -> None:
    file, claim = study(), claim_folder(Path("out"))
    with ThreadPoolExecutor(1) as other:
        other.submit(claim.__enter__).result()
        refused = wucht("run", file, "-o", "out")
        elsewhere = wucht("run", file, "-o", "other")
        assert not list(Path("out").glob("result.nc"))
        other.submit(claim.__exit__, None, None, None).result()
    assert refused.code == 2
    assert "-o: given 'out'; another run is writing a result there: wait until it has ended" in refused.err
    assert elsewhere.code == 0
    assert wucht("run", file, "-o", "out").code == 0


@pytest.mark.usefixtures("no_figures")
def test_names_with_spaces_and_umlauts(wucht: Command, study: Study) -> None:
    Path("M\u00fchle 1").mkdir()
    file = study('"A drum with two pendulums"', '"M\u00fchle \u2713"', name="M\u00fchle 1/l\u00e4uft nicht.toml")
    actual = wucht("run", file, "-o", "M\u00fchle 1/Ergebnis 1", "--json").document
    assert actual["machine"] == "M\u00fchle \u2713"
    assert Path("M\u00fchle 1/Ergebnis 1/result.nc").is_file()
    assert wucht("plot", "M\u00fchle 1/Ergebnis 1/result.nc").code == 0


@pytest.mark.usefixtures("no_figures")
def test_a_study_without_a_question_runs_until_settled(wucht: Command) -> None:
    Path("study.toml").write_text(ROTOR_ALONE.split("[study]", maxsplit=1)[0])
    actual = wucht("run", "study.toml", "-o", "out", "--json").document
    assert actual["machine"] == "study"
    assert actual["summary"]["outcome"] == "passed"
    assert actual["summary"]["final_phases"] == {}


# use and set


def _values(file: Path | str, **settings: Any) -> dict[str, float]:
    from wucht.studies.study_file import read_study

    return read_study(str(file), settings).subject.values


SETS = {
    "quoted": 'set = { "drive.slope" = "0.02 N m s", "carrier.mass" = 3 }',
    "nested": 'set = { drive = { slope = "0.02 N m s" }, carrier = { mass = 3 } }',
    "tables": "[machine.set.drive]\nslope = 0.02\n[machine.set.carrier]\nmass = 3",
}


@pytest.mark.parametrize("written", SETS.values(), ids=SETS.keys())
def test_every_way_to_write_set(here: Path, written: str) -> None:
    Path("study.toml").write_text(f'[machine]\nuse = "drozdetskaya-2020/r1"\n{written}\n')
    values = _values("study.toml")
    assert values["drive.slope"] == 0.02
    assert values["carrier.mass"] == 3.0
    assert values["drum.mass"] == 9.75


@pytest.mark.usefixtures("no_figures")
def test_the_last_setting_wins(wucht: Command, here: Path) -> None:
    Path("deep").mkdir()
    Path("deep/base.toml").write_text(
        'title = "base"\n[machine]\nuse = "drozdetskaya-2020/r1"\nset = { drive.slope = 1, p1.damping = 1 }\n'
    )
    Path("deep/mid.toml").write_text('[machine]\nuse = "base.toml"\nset = { drive.slope = 2, "p2.damping" = 2 }\n')
    Path("top.toml").write_text('[machine]\nuse = "deep/mid.toml"\ntitle = "top"\nset = { drum.mass = 20 }\n')
    values = _values("top.toml", **{"drum.inertia": "1 kg m^2"})
    expected = {"drive.slope": 2.0, "p1.damping": 1.0, "p2.damping": 2.0, "drum.mass": 20.0, "drum.inertia": 1.0}
    assert {key: values[key] for key in expected} == expected
    settings = ("drive.slope=3", "drive.slope=4 N m s", "study.until=1e-2")
    completed = wucht("run", "top.toml", "-o", "out", "--json", *(word for s in settings for word in ("--set", s)))
    assert completed.document["machine"] == "top (changed: drive.slope = 4 N m s)"
    stored = _stored(Path("out/result.nc"))
    assert (stored["drive.slope"], stored["p2.damping"]) == (4.0, 2.0)


def _stored(file: Path) -> dict[str, float]:
    import xarray as xr

    actual = xr.load_dataset(file, engine="h5netcdf")
    return dict(json.loads(actual.attrs["input"])["machine"]["parameters"])


@pytest.mark.usefixtures("no_figures")
def test_use_is_relative_to_the_file_not_to_the_working_directory(
    wucht: Command, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("project/machines").mkdir(parents=True)
    Path("project/machines/mine.toml").write_text(ROTOR_ALONE.split("[study]", maxsplit=1)[0])
    Path("project/study.toml").write_text('[machine]\nuse = "machines/mine.toml"\n[study]\nkind = "run-up"\nuntil = "0.1 s"\n')
    Path("elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")
    for name in ("../project/study.toml", here / "project/study.toml"):
        completed = wucht("run", name, "-o", "out", "--json")
        assert completed.code == 0, completed.err
        assert Path("out/result.nc").is_file()
    assert wucht("equations", "../project/study.toml").code == 0
    assert not (here / "project/results").exists()


@pytest.mark.parametrize("directions", ["x", "xy"])
def test_a_component_of_what_is_one_number(refused: Refused, study: Study, directions: str) -> None:
    file = study('"1 kg"', f'"1 kg"\ndirections = "{directions}"')
    refused("run", file, "--json", "--set", "carrier.stiffness.x=1e5", says=("carrier.stiffness", "one number"))


@pytest.mark.usefixtures("no_figures")
def test_settings_of_the_question(wucht: Command, study: Study) -> None:
    import xarray as xr

    words = (
        "carrier.stiffness=[1e5, 2e5]",
        "carrier.stiffness.x=3e5",
        "study.until=0.2 s",
        "study.start.p1=0.4",
        "study.start.p2.speed=3 rad/s",
        "study.start.carrier.x=1 mm",
    )
    completed = wucht("run", study(), "-o", "out", "--json", *(w for s in words for w in ("--set", s)))
    assert completed.code == 0, completed.err
    stored = _stored(Path("out/result.nc"))
    assert (stored["carrier.stiffness.x"], stored["carrier.stiffness.y"]) == (3e5, 2e5)
    actual = xr.load_dataset("out/result.nc", engine="h5netcdf").isel(time=[0, -1])
    assert actual.time.values.tolist() == pytest.approx([0.0, 0.2])
    assert actual.angle.isel(time=0).values.tolist() == pytest.approx([0.0, 0.4, -0.5])
    assert actual.speed.isel(time=0).values.tolist() == pytest.approx([0.0, 0.0, 3.0])
    assert actual.displacement.isel(time=0).values.tolist() == pytest.approx([1e-3, 0.0])


# What is doubtful


DOUBTS = {
    "unbalance too large": ('"1 mm"', '"10 mm"', "more than the 0.026 kg m"),
    "one balancer too large": ('"125 g"', '"12.5 kg"', "more than the rotor and all other balancers"),
}


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(("old", "new", "says"), DOUBTS.values(), ids=DOUBTS.keys())
def test_doubtful_input_runs_with_a_warning(wucht: Command, study: Study, old: str, new: str, says: str) -> None:
    completed = wucht("run", study(old, new), "-o", "out", "--json")
    assert completed.code == 0, completed.err
    assert any(says in warning for warning in completed.document["warnings"])
    loud = wucht("run", study(old, new), "-o", "out")
    assert loud.code == 0
    assert units_in_print(says) in loud.err
    assert units_in_print(says) not in loud.out


# Runs that fail


@pytest.mark.filterwarnings("error")  # they would stand on stderr beside the sentence
@pytest.mark.parametrize("engine", ["compiled", pytest.param("radau", marks=pytest.mark.slow)])
def test_a_run_that_fails_says_when_where_and_what_to_do(wucht: Command, study: Study, engine: str) -> None:
    file = study('p1 = "0.3 rad"', "carrier = { x = 1e12 }", 'until = "0.5 s"', f'until = 0.5\nengine = "{engine}"')
    completed = wucht("run", file, "-o", "out", "--json")
    assert completed.code == 1
    assert "t = " in completed.err
    assert "carrier." in completed.err or "p1." in completed.err or "drum." in completed.err
    assert any(advice in completed.err for advice in ("Look for", "Try", "ask for"))
    assert "Traceback" not in completed.err
    assert completed.err.rstrip("\n").count("\n") == 0 or completed.err.startswith("running")
    actual = _parsed(completed.out)
    assert actual["summary"]["outcome"] == "failed"
    assert actual["summary"].keys() >= SUMMARY
    assert "What was computed so far is in out/result.partial.nc\n" in completed.err
    assert wucht("plot", "out/result.partial.nc").code == 0


# plot


SIGNATURES = {"png": b"\x89PNG\r\n\x1a\n", "pdf": b"%PDF-", "svg": b"<?xml"}


@pytest.mark.usefixtures("no_figures")
def test_plot_of_a_folder_in_several_formats(wucht: Command, refused: Refused, study: Study) -> None:
    assert wucht("run", study('"0.5 s"', '"0.01 s"'), "-o", "out", "--json").code == 0
    said = wucht("plot", "out", "--format", "svg", "--format", "pdf", "--format", "svg").out
    assert said == "out/run-up.svg\nout/run-up.pdf\n"
    assert all(Path(f).read_bytes().startswith(SIGNATURES[f[-3:]]) for f in said.split())
    Path("empty").mkdir()
    refused("plot", "empty", says=("empty/result.nc", "no such file"))
    refused("plot", "out", "--format", "bmp", says=("bmp", "svg"))


@pytest.mark.usefixtures("no_figures")
def test_the_result_holds_its_whole_input(wucht: Command, study: Study) -> None:
    import xarray as xr

    assert wucht("run", study('"0.5 s"', '"0.01 s"'), "-o", "out", "--json", "--set", "p1.mass=0.2").code == 0
    actual = xr.load_dataset("out/result.nc", engine="h5netcdf")
    kept = json.loads(actual.attrs["document"])
    assert kept["study"]["until"] == "0.01 s"
    assert kept["machine"]["bodies"][1]["mass"] == 0.2
    assert json.loads(actual.attrs["versions"])["wucht"] == package.__version__
    assert all("units" in v.attrs and v.attrs["long_name"] for v in actual.data_vars.values())


# new, list, equations


@pytest.mark.parametrize("name", ["drozdetskaya-2020/table-5.1", "practice/laundry-drum"])
def test_new_copies_from_the_catalogue(wucht: Command, name: str) -> None:
    assert wucht("new", name, "mine.toml").code == 0
    assert _values("mine.toml") == _values(name)
    assert wucht("new", name).code == 0
    assert Path(Path(name).name + ".toml").is_file()


def test_equations_are_readable(wucht: Command, study: Study) -> None:
    completed = wucht("equations", study())
    assert completed.code == 0
    for expected in ("A drum with two pendulums", "phi''", "sin(phi)", "drum.mass", "0.125 kg"):
        assert expected in completed.out
    assert "0.2 kg" in wucht("equations", "study.toml", "--set", "p1.mass=0.2").out


# As a process of its own


def _process(*words: str, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "wucht", *words],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=_environment(),
        **options,
    )


def _environment() -> dict[str, str]:
    source = str(Path(package.__file__).parent.parent)
    return {**os.environ, "PYTHONPATH": os.pathsep.join([source, os.environ.get("PYTHONPATH", "")])}


@pytest.mark.slow
def test_stdout_of_the_process_is_the_object_alone(study: Study, here: Path) -> None:
    study()
    Path("sub").mkdir()
    done = _process("run", "../study.toml", "--json", "-o", "../out", cwd=here / "sub")
    assert done.returncode == 0
    assert _parsed(done.stdout).keys() >= OBJECT
    assert "Warning" not in done.stderr
    assert (here / "out/result.nc").is_file()


@pytest.mark.usefixtures("unpainted")
def test_styles_and_formats_of_figures(wucht, study):
    """Both commands take them; what they are drawn on is the page that is asked for, and no second figure is left."""
    assert wucht("run", study(), "-o", "out", "--style", "journal", "--format", "svg").code == 0
    assert sorted(p.name for p in Path("out").iterdir()) == ["result.nc", "run-up.svg", "summary.json"]
    assert 'width="249.4' in Path("out/run-up.svg").read_text()
    assert wucht("plot", "out/result.nc", "--style", "print", "--format", "pdf").out.strip() == "out/run-up.pdf"
    assert Path("out/run-up.pdf").read_bytes().startswith(b"%PDF")
