"""The commands of the contract, as a user calls them."""

from __future__ import annotations

import json
import os
import shutil
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
OUTCOMES = {
    "compensated", "passed", "captured", "captured-modulated", "balancer-captured", "stopped", "oscillating", "runaway",
    "unidentified", "failed",
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
def test_a_captured_beating_machine_has_its_periods(wucht: Command) -> None:
    actual = wucht("run", "drozdetskaya-2020/r1", "-o", "out", "--json").document["summary"]
    assert actual["outcome"] == "captured-modulated"
    assert actual["outcome"] in OUTCOMES
    # The mean speed over one period ties both periods together.
    assert actual["modulation_period_phi"] / actual["modulation_period"] == pytest.approx(actual["final_speed"], rel=1e-3)


@pytest.mark.usefixtures("no_figures")
def test_without_json_the_verdict_is_read_first(wucht: Command, study: Study) -> None:
    completed = wucht("run", study('until = "0.5 s"', "settled = true"), "-o", "out")
    assert completed.code == 0
    assert "COMPENSATED" in completed.out.splitlines()[1]
    assert "200 rad/s (1910 rpm)" in completed.out
    assert "result.nc" in completed.out
    assert "Traceback" not in completed.err


@pytest.mark.usefixtures("no_figures")
def test_the_default_folder(wucht: Command, study: Study) -> None:
    assert wucht("run", study()).code == 0
    assert Path("results/study/result.nc").is_file()
    assert wucht("run", "drozdetskaya-2020/table-3.1-carrier", "--set", "study.until=100").code == 0
    assert Path("results/drozdetskaya-2020/table-3.1-carrier/result.nc").is_file()
    assert wucht("run", "study.toml", "--set", "study.kind=response").code == 0
    assert Path("results/study/response/response.png").is_file()
    assert Path("results/study/run-up.png").is_file()


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
def test_folders_are_made_and_results_replaced(wucht: Command, study: Study) -> None:
    file = study()
    first = wucht("run", file, "-o", "a/b/c", "--json").document
    second = wucht("run", file, "-o", "a/b/c", "--json", "--set", "study.until=1").document
    assert second["files"] == first["files"]
    assert second["summary"]["final_speed"] > first["summary"]["final_speed"]
    assert sorted(p.name for p in Path("a/b/c").iterdir()) == ["result.nc", "run-up.png", "summary.json"]


@pytest.mark.usefixtures("no_figures")
def test_names_with_spaces_and_umlauts(wucht: Command, study: Study) -> None:
    Path("M\u00fchle 1").mkdir()
    file = study('"A drum with two pendulums"', '"M\u00fchle \u2713"', name="M\u00fchle 1/l\u00e4uft nicht.toml")
    actual = wucht("run", file, "-o", "M\u00fchle 1/Ergebnis 1", "--json").document
    assert actual["machine"] == "M\u00fchle \u2713"
    assert Path("M\u00fchle 1/Ergebnis 1/result.nc").is_file()
    assert wucht("plot", "M\u00fchle 1/Ergebnis 1/result.nc").code == 0


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_a_folder_of_a_catalogue_name_hides_nothing(wucht: Command) -> None:
    Path("drozdetskaya-2020/table-3.1-carrier").mkdir(parents=True)
    assert wucht("run", "drozdetskaya-2020/table-3.1-carrier", "--set", "study.until=100", "--json").code == 0


@pytest.mark.usefixtures("no_figures")
def test_a_study_without_a_question_runs_until_settled(wucht: Command) -> None:
    Path("study.toml").write_text(ROTOR_ALONE.split("[study]", maxsplit=1)[0])
    actual = wucht("run", "study.toml", "-o", "out", "--json").document
    assert actual["machine"] == "study"
    assert actual["summary"]["outcome"] == "passed"
    assert actual["summary"]["final_phases"] == {}


@pytest.mark.usefixtures("no_figures")
def test_files_of_other_editors(wucht: Command) -> None:
    Path("study.toml").write_bytes(ROTOR_ALONE.replace("\n", "\r\n").encode())
    assert wucht("run", "study.toml", "-o", "out", "--json").code == 0


# Quick is one of each kind: a number, a word, a table; other keys are read by the same readers of units.
FORMS = {
    "until a number": "until = 0.5",
    "until a time": 'until = "500 ms"',
    "until settled": 'until = "settled"',
    "until a table": "until = { turns = 3 }",
    "turns": "turns = 3",
    "model": 'until = 0.5\nmodel = "full"',
    "tolerance": "until = 0.5\ntolerance = 1e-9",
    "tolerance a text": 'until = 0.5\ntolerance = "1e-9"',
    "settled false beside until": "until = 0.5\nsettled = false",
    "engine": 'until = 0.1\nengine = "radau"',
}


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    "question",
    [
        pytest.param(
            q, id=name, marks=() if name in ("until a time", "until settled", "until a table", "engine") else pytest.mark.slow
        )
        for name, q in FORMS.items()
    ],
)
def test_every_form_of_the_question(wucht: Command, study: Study, question: str) -> None:
    completed = wucht("run", study('until = "0.5 s"', question), "-o", "out", "--json")
    assert completed.code == 0, completed.err
    assert completed.document["summary"]["outcome"] in OUTCOMES


# use and set


def _values(file: Path | str, **settings: Any) -> dict[str, float]:
    from wucht.studies.study_file import read_study

    return read_study(str(file), settings).subject.values


SETS = {
    "quoted": 'set = { "drive.slope" = "0.02 N m s", "carrier.mass" = 3 }',
    "dotted": 'set = { drive.slope = "0.02 N m s", carrier.mass = 3 }',
    "nested": 'set = { drive = { slope = "0.02 N m s" }, carrier = { mass = 3 } }',
    "dotted from the table on": 'set.drive.slope = "0.02 N m s"\nset.carrier.mass = "3 kg"',
    "a table": '[machine.set]\n"drive.slope" = 0.02\ncarrier.mass = "3000 g"',
    "tables": "[machine.set.drive]\nslope = 0.02\n[machine.set.carrier]\nmass = 3",
}


@pytest.mark.parametrize("written", SETS.values(), ids=SETS.keys())
def test_every_way_to_write_set(here: Path, written: str) -> None:
    Path("study.toml").write_text(f'[machine]\nuse = "drozdetskaya-2020/r1"\n{written}\n')
    values = _values("study.toml")
    assert values["drive.slope"] == 0.02
    assert values["carrier.mass"] == 3.0
    assert values["drum.mass"] == 9.75


def test_set_of_a_dimensionless_machine(here: Path) -> None:
    Path("study.toml").write_text('[machine]\nuse = "drozdetskaya-2020/table-5.1"\nset = { u = 1.5, lambda = 2.5 }\n')
    values = _values("study.toml")
    assert (values["u"], values["lambda"], values["mu"]) == (1.5, 2.5, 0.01)


@pytest.mark.usefixtures("no_figures")
def test_the_last_setting_wins(wucht: Command, here: Path) -> None:
    Path("deep").mkdir()
    Path("deep/base.toml").write_text(
        'title = "base"\n[machine]\nuse = "drozdetskaya-2020/r1"\nset = { drive.slope = 1, p1.damping = 1 }\n'
    )
    Path("deep/mid.toml").write_text('[machine]\nuse = "base.toml"\nset = { drive.slope = 2, "p2.damping" = 2 }\n')
    Path("top.toml").write_text('[machine]\nuse = "deep/mid.toml"\ntitle = "top"\nset = { drum.mass = 20 }\n')
    values = _values("top.toml", **{"drum.inertia": "1 kg m^2"})
    assert [values[k] for k in ("drive.slope", "p1.damping", "p2.damping", "drum.mass", "drum.inertia")] == [
        2.0,
        1.0,
        2.0,
        20.0,
        1.0,
    ]
    completed = wucht(
        "run",
        "top.toml",
        "-o",
        "out",
        "--json",
        "--set",
        "drive.slope=3",
        "--set",
        "drive.slope=4 N m s",
        "--set",
        "study.until=1e-2",
    )
    assert completed.document["machine"] == "top (changed: drive.slope = 4 N m s)"
    stored = _stored(Path("out/result.nc"))
    assert stored["drive.slope"] == 4.0
    assert stored["p2.damping"] == 2.0


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


PAIRS = {
    "one of a pair": (["carrier.stiffness=[1e5, 2e5]", "carrier.stiffness.x=3e5"], [3e5, 2e5]),
    "the other with a unit": (["carrier.stiffness=[1e5, 2e5]", "carrier.stiffness.y=3 N/mm"], [1e5, 3e3]),
    "a pair with units": (['carrier.stiffness=["1e5 N/m", "200 N/mm"]'], [1e5, 2e5]),
}


@pytest.mark.parametrize(("settings", "expected"), PAIRS.values(), ids=PAIRS.keys())
def test_settings_of_pairs(study: Study, settings: list[str], expected: list[float]) -> None:
    from wucht.cli.options import parse_settings

    values = _values(study(), **parse_settings(settings))
    assert [values["carrier.stiffness.x"], values["carrier.stiffness.y"]] == expected


@pytest.mark.parametrize("directions", ["x", "xy"])
def test_a_component_of_what_is_one_number(refused: Refused, study: Study, directions: str) -> None:
    file = study('"1 kg"', f'"1 kg"\ndirections = "{directions}"')
    refused("run", file, "--json", "--set", "carrier.stiffness.x=1e5", says=("carrier.stiffness", "one number"))


SETTINGS = {
    "a number": ("drive.slope=0.02", "drive.slope", 0.02),
    "a number with exponent": ("carrier.stiffness=2e5", "carrier.stiffness", 2e5),
    "a quantity": ("drive.no_load_speed=3000 rpm", "drive.no_load_speed", 314.159265358979),
    "turns a second": ("drive.no_load_speed=50 Hz", "drive.no_load_speed", 314.159265358979),
    "degrees a second": ("drive.no_load_speed=180 deg/s", "drive.no_load_speed", 3.14159265358979),
    "quotes": ('p1.mass="130 g"', "p1.mass", 0.13),
    "blanks": (" p1.mass = 130 g ", "p1.mass", 0.13),
    "an optional key": ("p1.inertia=1.69e-3", "p1.inertia", 1.69e-3),
}


@pytest.mark.parametrize(("setting", "key", "value"), SETTINGS.values(), ids=SETTINGS.keys())
def test_settings_from_the_command_line(study: Study, setting: str, key: str, value: float) -> None:
    from wucht.cli.options import parse_settings

    assert _values(study(), **parse_settings([setting]))[key] == pytest.approx(value, rel=1e-12)


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
    "far too short": ('"0.5 s"', '"1 ms"', "far too short"),
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


@pytest.mark.usefixtures("no_figures")
def test_a_machine_that_cannot_exist_is_doubted(wucht: Command) -> None:
    completed = wucht("run", "drozdetskaya-2020/table-5.1", "-o", "out", "--json", "--set", "study.until=50")
    assert completed.code == 0
    assert any("no machine has these parameters" in warning for warning in completed.document["warnings"])


@pytest.mark.usefixtures("no_figures")
def test_too_short_says_how_long(wucht: Command, study: Study) -> None:
    actual = wucht("run", study(), "-o", "out", "--json").document
    assert actual["summary"]["outcome"] == "unidentified"
    assert any("run at least until" in warning for warning in actual["warnings"])


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


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_plot_works_from_the_file_alone(wucht: Command, study: Study, here: Path) -> None:
    assert wucht("run", study(), "-o", "out", "--json").code == 0
    Path("elsewhere").mkdir()
    shutil.move("out/result.nc", "elsewhere/renamed.nc")
    shutil.rmtree("out")
    Path("study.toml").unlink()
    for ending, signature in SIGNATURES.items():
        completed = wucht("plot", "elsewhere/renamed.nc", "--format", ending)
        assert completed.code == 0, completed.err
        written = Path(completed.out.strip())
        assert written == Path("elsewhere") / f"run-up.{ending}"
        assert written.read_bytes().startswith(signature)
    completed = wucht("plot", here / "elsewhere/renamed.nc", "-o", "figures/new")
    assert Path("figures/new/run-up.png").is_file()


@pytest.mark.usefixtures("no_figures")
def test_plot_of_a_folder_in_several_formats(wucht: Command, refused: Refused, study: Study) -> None:
    assert wucht("run", study('"0.5 s"', '"0.01 s"'), "-o", "out", "--json").code == 0
    said = wucht("plot", "out", "--format", "svg", "--format", "pdf", "--format", "svg").out
    assert said == "out/run-up.svg\nout/run-up.pdf\n"
    assert all(Path(f).read_bytes().startswith(SIGNATURES[f[-3:]]) for f in said.split())
    Path("empty").mkdir()
    refused("plot", "empty", says=("empty/result.nc", "no such file"))
    refused("plot", "out", "--format", "bmp", says=("bmp", "svg"))


def test_plot_into_a_folder_that_cannot_be_written(wucht: Command, refused: Refused, study: Study) -> None:
    assert wucht("run", study('"0.5 s"', '"0.01 s"'), "-o", "out", "--json").code == 0
    refused("plot", "out/result.nc", "-o", "study.toml", says=("-o", "given 'study.toml'"))
    refused("plot", "out/result.nc", "-o", "study.toml/below", says=("-o", "given 'study.toml/below'"))


@pytest.mark.usefixtures("no_figures")
def test_half_a_result_is_refused(wucht: Command, refused: Refused, study: Study) -> None:
    assert wucht("run", study('"0.5 s"', '"0.01 s"'), "-o", "out", "--json").code == 0
    whole = Path("out/result.nc").read_bytes()
    for size in (100, len(whole) // 2, len(whole) - 100):
        Path("half.nc").write_bytes(whole[:size])
        refused("plot", "half.nc", says=("half.nc: ",))


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


@pytest.mark.usefixtures("no_figures")
def test_new_writes_a_study_that_runs(wucht: Command) -> None:
    completed = wucht("new", "run-up")
    assert completed.code == 0
    assert "run-up.toml" in completed.out
    text = Path("run-up.toml").read_text()
    assert text.count("#") > 10, "the file explains itself"
    assert wucht("run", "run-up.toml", "-o", "out", "--json").document["summary"]["outcome"] == "compensated"


@pytest.mark.parametrize("name", ["drozdetskaya-2020/r1-u40", "drozdetskaya-2020/table-5.1", "practice/laundry-drum"])
def test_new_copies_from_the_catalogue(wucht: Command, name: str) -> None:
    assert wucht("new", name, "mine.toml").code == 0
    assert _values("mine.toml") == _values(name)
    assert wucht("new", name).code == 0
    assert Path(Path(name).name + ".toml").is_file()


def test_list_has_a_line_each(wucht: Command) -> None:
    from wucht.files.catalogue import names

    completed = wucht("list")
    assert completed.code == 0
    lines = [line.split() for line in completed.out.splitlines()]
    first = [words[0] for words in lines if len(words) > 1]
    kinds = ("xy", "xyr", "fixed", "rotor", "slider", "pendulum", "roller", "linear", "constant-speed", "induction", "coulomb")
    for name in (*kinds, "run-up", "sweep", "laval-rotor", *names()):
        assert first.count(name) == 1, name


def test_equations_are_readable(wucht: Command, study: Study) -> None:
    completed = wucht("equations", study())
    assert completed.code == 0
    for expected in ("A drum with two pendulums", "phi''", "sin(phi)", "drum.mass", "0.125 kg"):
        assert expected in completed.out
    assert "0.2 kg" in wucht("equations", "study.toml", "--set", "p1.mass=0.2").out


def test_equations_for_latex(wucht: Command, study: Study) -> None:
    completed = wucht("equations", study(), "--latex")
    assert completed.code == 0
    assert completed.out.count("\\begin{align}") == completed.out.count("\\end{align}") == 2, "formulas of drives are apart"
    assert completed.out.count("{") == completed.out.count("}")
    body = completed.out.split("\\begin{align}")[1].split("\\end{align}")[0]
    numbered_lines = [line for line in body.strip().split("\\\\\n") if "\\notag" not in line]
    assert len(numbered_lines) == 5, "one equation for each of x, y, phi, theta_1, theta_2"


@pytest.mark.parametrize("words", [("--version",), ("-h",), ("run", "--help"), ("plot", "-h"), ("new", "-h"), ("list", "-h")])
def test_help_and_version(wucht: Command, words: tuple[str, ...]) -> None:
    completed = wucht(*words)
    assert completed.code == 0
    assert completed.out
    assert not completed.err


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


def test_stdout_of_the_process_is_the_object_alone(study: Study, here: Path) -> None:
    study()
    Path("sub").mkdir()
    done = _process("run", "../study.toml", "--json", "-o", "../out", cwd=here / "sub")
    assert done.returncode == 0
    assert _parsed(done.stdout).keys() >= OBJECT
    assert "Warning" not in done.stderr
    assert (here / "out/result.nc").is_file()


def test_bad_input_of_the_process(here: Path) -> None:
    said = "nowhere.toml: there is no such file"
    done = _process("run", "nowhere.toml", cwd=here)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"wucht: {said}\n")
    done = _process("run", "nowhere.toml", "--json", cwd=here)
    assert (done.returncode, done.stderr) == (2, f"wucht: {said}\n")
    assert _parsed(done.stdout)["error"] == said


def test_a_reader_who_has_seen_enough(here: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as closed:
        done = subprocess.run(
            [sys.executable, "-m", "wucht", "list"], stdout=closed, stderr=subprocess.PIPE, text=True, timeout=60, check=False,
            env=_environment(), cwd=here,
        )  # fmt: skip
    assert "Traceback" not in done.stderr
    assert "BrokenPipe" not in done.stderr


@pytest.mark.parametrize("text", ['{ drum = { speed = "5 rad/s" }, p1 = 0.3 }', '{"drum": {"speed": "5 rad/s"}, "p1": 0.3}'])
def test_a_table_is_set_from_the_command_line(text: str) -> None:
    from wucht.cli.options import parse_settings

    assert parse_settings([f"study.start={text}"]) == {"study.start": {"drum": {"speed": "5 rad/s"}, "p1": 0.3}}


@pytest.mark.usefixtures("unpainted")
def test_styles_and_formats_of_figures(wucht, study):
    """Both commands take them; what they are drawn on is the page that is asked for, and no second figure is left."""
    assert wucht("run", study(), "-o", "out", "--style", "journal", "--format", "svg").code == 0
    assert sorted(p.name for p in Path("out").iterdir()) == ["result.nc", "run-up.svg", "summary.json"]
    assert 'width="249.4' in Path("out/run-up.svg").read_text()
    assert wucht("plot", "out/result.nc", "--style", "print", "--format", "pdf").out.strip() == "out/run-up.pdf"
    assert Path("out/run-up.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(("option", "value", "allowed"), [("--style", "poster", "journal"), ("--format", "gif", "svg")])
def test_unknown_styles_and_formats_are_refused(refused, study, option, value, allowed):
    refused("run", study(), option, value, says=(value, allowed))
