"""Everything that a user can get wrong: one sentence with file, key, what was given and what it must be, and exit code 2.

The sentences are in ``tests/stated/refusals.json``.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.conftest import STUDY
from tests.refusals import cases_of, check_file, check_refusal

from wucht import __version__ as version
from wucht import run_file

Refused = Callable[..., str]
Study = Callable[..., Path]
Command = Callable[..., Any]

DRIVE = 'on = "drum"\nkind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"\n'
UNTIL = 'until = "0.5 s"'
CARRIER = "[machine.carrier]"
P1 = 'kind = "pendulum"\nname = "p1"\nabout = "drum"\nmass = "125 g"\nlength = "104 mm"'
ROLLER = 'kind = "roller"\nname = "p1"\nabout = "drum"\nmass = "125 g"\ntrack_radius = 0.1\nradius = 0.2'

# What stands in the place of a text of the study file. Nothing: a key is missing.
CHANGES = {
    # keys
    "title =": ["titel ="], "stiffness =": ["stifness ="], "until": ["untill"], "{ p1 =": ["{ p3 ="],
    'p1 = "0.3 rad"': ["p1 = { angel = 1 }", "carrier = { z = 1 }"],
    'mass = "9 kg"\n': [""], 'stiffness = "1e5 N/m"\n': [""], 'about = "drum"\n': [""], 'slope = "0.04 N m s"\n': [""],
    'eccentricity = "1 mm"\n': ["", 'eccentricity = "1 mm"\nunbalance = 1e-3\n'],
    # kinds and names
    'kind = "rotor"': ["", 'knid = "rotor"', 'kind = "roter"', "kind = 3"], 'kind = "linear"': ["", 'kind = "liner"'],
    'kind = "run-up"': ["", 'kind = "runup"', "kind = true"], 'about = "drum"': ['about = "dram"', 'about = "p1"'],
    'on = "drum"': ['on = "dram"', 'on = ["drum"]'], 'name = "p2"': ['name = "carrier"', 'name = "p1"'],
    'name = "drum"': ["", 'name = "a.b"', 'name = "drum\\n"', 'name = ""', "name = { a = 1 }"],
    # quantities
    '"104 mm"': ['"3 kg"', '"-104 mm"', "1e300"],
    '"1e5 N/m"': [
        '["1 N/m", "1 kg"]', "-1", "[1, -1]", "1e308", '[1, 2]\ndirections = "x"', "[1]", "[1, 2, 3]", "[[1], [2]]",
    ],
    '"9 kg"': [
        '"9 kilopound_x"', '"9 kg kg) ("', '"-9 kg"', "0", "1e-320", "nan", '"-inf kg"', "1e400", '"1e400 kg"', "1" + 400 * "0",
        # what looks like a quantity and is none: never to be computed, or to be read as another number
        *(f'"{text}"' for text in ("1,5 kg", "1 000 kg", "1 kg + 1 m", "9**9 kg", "__import__('os')", 3000 * "(" + "1 kg")),
        "true", "[1]", "{ a = 1 }", "1979-05-27", '"  "',
    ],
    '"0.5 s"': ["inf", "true"], '"200 N s/m"': ["-1"], '"0.03 kg m^2"': ["8.9e-6"], '"1 mm"': ["1e300"],
    'length = "104 mm"': ['length = "104 mm"\ninertia = 1e-9'], P1: [ROLLER], '"200 rad/s"': ["-1e308"],
    '"0.3 rad"': ["1979-05-27", "nan"], '"A drum with two pendulums"': ['"a\\u0000b"', "3"],
    'mass = "1 kg"': ['directions = "z"'],
    # the question
    UNTIL: [
        "until = { turn = 3 }", 'until = "3 kg"', 'until = "0 s"', "until = {}", "turns = 0", "settled = false",
        "turns = 3\nsettled = true",
        *(
            f"{UNTIL}\n{more}"
            for more in (
                'model = "fulll"', 'model = "slow"\norder = 3', "order = 2", 'model = "both"\ninertia = 1', "inertia = true",
                'model = ["full", "slow"]', 'engine = "heyokka"', "tolerance = 0", "tolerance = 1", "speed_limit = 0",
                "turns = 3",
            )
        ),
    ],
    '{ p1 = "0.3 rad", p2 = "-0.5 rad" }': [
        "{ drum = { speed = 1e308 } }", '{ p1 = "3 kg" }', '{ carrier = { x = "1 kg" } }', "{ psi = 1, p1 = 2 }",
    ],
    # drives, and what stands beside parts
    f"[machine.drive]\n{DRIVE}": ["", 2 * f"[[machine.drives]]\n{DRIVE}"],
    "[machine.drive]": [f"[[machine.drives]]\n{DRIVE}[machine.drive]"],
    DRIVE: ['on = "drum"\nkind = "table"\npoints = [[0, 1e308], [1, -1e308]]\n'],
    CARRIER: [
        f"{more}\n{CARRIER}"
        for more in (
            "[machine]\nbodys = 1", '[machine]\nmodel = "laval-rotor"', '[machine]\nmodel = "lavalrotor"',
            "[machine.parameters]\nu = 1", '[machine]\nuse = "drozdetskaya-2020/r1"', '[machine]\nset = { "p3.mass" = 1 }',
            '[machine]\nset = { "p1.masss" = 1 }',
        )
    ],
}  # fmt: skip


@pytest.mark.parametrize(("old", "new"), cases_of(CHANGES))
def test_what_is_wrong_in_a_file(here: Path, old: str, new: str) -> None:
    check_file("study", STUDY, {old: new})


SPEED = 'kind = "constant-speed"\nspeed = 100\n'


def test_two_places_of_a_file(here: Path) -> None:
    """Bodies about each other; the start of a body whose speed is prescribed."""
    check_file("study", STUDY, {'about = "drum"': 'about = "p2"', '"p2"\nabout = "drum"': '"p2"\nabout = "p1"'})
    check_file("study", STUDY, {DRIVE: SPEED, 'p1 = "0.3 rad"': "drum = 1"})


USED = "[machine]\nuse = 'drozdetskaya-2020/r1'\n"
WHOLE = [
    "", "machine = 'x'\n", "[[machine]]\n", "[study]\nkind = 'run-up'\n", "machine = { carrier = [1] }\n",
    *(
        f"[machine]\n{key}\ncarrier = {{ stiffness = 1 }}\n"
        for key in ("bodies = 'x'", "bodies = [1]", "bodies = []", "set = [1]", "bodies = 3\nset = { carrier.mass = 1 }")
    ),
    *(f"{USED}{key}\n" for key in ("set = 'x'", "model = 'laval-rotor'", "carrier = {}", "x = 1")),
    *(f"[machine]\nmodel = {model}\n" for model in ("['laval-rotor']", "'laval-rotor'\nparameters = 'x'\nset = { u = 1 }")),
    *(f"[machine]\nuse = {use}\n" for use in ("3", "''", "'other.toml'", "'drozdetskaya-2020/table-5.2'", "'study.toml'")),
    f"study = 'x'\n{USED}",
    *(f"[study]\nkind = 'run-up'\n{key}\n{USED}" for key in ("start = [1]", "settled = 1", "model = ['slow']")),
]  # fmt: skip


@pytest.mark.parametrize("text", WHOLE)
def test_a_table_is_a_table(here: Path, text: str) -> None:
    check_file("whole", "", {"": text})


# Files


NO_STUDY_FILES = {
    "no TOML": (b"hello world", "not valid TOML", "line 1"),
    "UTF-16": ("title = 'x'".encode("utf-16"), "UTF-8"),
    "NUL": (b"title = '\0'", "not valid TOML"),
    "a key twice": (b"title = 'a'\ntitle = 'b'\n", "not valid TOML", "line 2"),
    "nested arrays": (b"a = " + 5000 * b"[", "not valid TOML"),
    "an endless number": (b"\na = 1" + 6000 * b"0", "not valid TOML: a number of thousands of digits (at line 2)"),
    "a key of many parts": (b"machine." + 3000 * b"a." + b"a = 1", "broken.toml: machine: at most 40 tables"),
}


@pytest.mark.parametrize("case", NO_STUDY_FILES.values(), ids=NO_STUDY_FILES.keys())
def test_a_file_that_is_no_toml(refused: Refused, here: Path, case: tuple[Any, ...]) -> None:
    content, *says = case
    Path("broken.toml").write_bytes(content)
    for command in ("run", "equations"):
        refused(command, "broken.toml", says=("broken.toml: ", *says))


def test_a_folder_for_a_file(refused: Refused, here: Path) -> None:
    Path("folder.toml").mkdir()
    Path("folder").mkdir()
    refused("run", "folder.toml", "--json", says=("folder.toml: ", "folder"))
    refused("run", "folder", "--json", says=("folder: ", "not a file"))
    refused("run", ".", "--json", says=("not a file",))
    refused("run", "", "--json")


def test_an_unknown_catalogue_name(refused: Refused) -> None:
    near = ("FILE: given", "did you mean 'drozdetskaya-2020/table-5.1',", "`wucht list` prints all names")
    refused("run", "drozdetskaya-2020/table-5.2", "--json", says=near)
    refused("run", "practice/nothing", says=("must be a study or machine file, or a catalogue name; `wucht",))
    refused("run", "nowhere.toml", "--json", says=("nowhere.toml: ", "there is no such file"))


def test_an_error_in_a_used_file_names_both(refused: Refused, here: Path) -> None:
    Path("study.toml").write_text('[machine]\nuse = "other.toml"\n')
    Path("other.toml").write_text("machin = 1\n")
    refused("run", "study.toml", says=("other.toml: ", "machin", "did you mean 'machine'?"))
    Path("other.toml").write_text("not toml")
    refused("run", "study.toml", says=("other.toml: ", "not valid TOML"))
    Path("other.toml").write_text("[machine]\nuse = 'drozdetskaya-2020/r1'\nbodies = []\n")
    refused("run", "study.toml", says=("other.toml: ", "machine.bodies", "not allowed beside use"))


def test_files_that_use_each_other(refused: Refused, here: Path) -> None:
    Path("a.toml").write_text('[machine]\nuse = "a.toml"\n')
    refused("run", "a.toml", "--json", says=("a.toml: ", "machine.use", "given 'a.toml'", "circle"))
    Path("b").mkdir()
    Path("a.toml").write_text('[machine]\nuse = "b/b.toml"\n')
    Path("b/b.toml").write_text('[machine]\nuse = "../a.toml"\n')
    for name in ("a.toml", "b/b.toml"):
        refused("run", name, "--json", says=("a.toml", "b.toml", "machine.use", "circle"))


# Output


@pytest.mark.parametrize("out", ["file/below", 300 * "y"])
def test_a_folder_that_cannot_be_written(refused: Refused, study: Study, out: str) -> None:
    Path("file").write_text("I am a file")
    refused("run", study(), "-o", out, "--json", says=("-o", f"given '{out[:20]}", "written"))
    assert Path("file").read_text() == "I am a file"


# Settings

SETTINGS = [
    "p1=3", "bogus={}", "study.until=1e300", "p3.mass=1", "p1.masss=1", "p1..mass=1", ".=3", "machine.p1.mass=1", "bodies=3",
    "drive.slope=3 kg", "drive.slope=nan", "drive.slope=[1, 2]", "carrier.stiffness=[NaN, 1]", 'drive.slope={"a": 1}',
    "p1.mass=-1", "p1.name=p2", "p1.mass.x=1", "carrier.stiffness.z=1", "study=3", "study.=3", "study.untill=3",
    "study.until=3 kg", "study.settled=yes", "study.kind=exciter-desing", "study.start.p3=1", 'study.start={"p1": NaN}',
]  # fmt: skip


def setting_of(text: str) -> dict[str, Any]:
    """KEY=VALUE as the command line reads it: JSON, or else a text."""
    key, _, value = text.partition("=")
    try:
        return {key: json.loads(value)}
    except ValueError:
        return {key: value}


@pytest.mark.parametrize("text", SETTINGS)
def test_a_wrong_setting(here: Path, text: str) -> None:
    check_file("study", STUDY, {}, setting_of(text))


@pytest.mark.parametrize("text", ["drive.slope=1", "u=1 kg"])
def test_a_setting_of_a_dimensionless_machine(text: str) -> None:
    check_refusal(f"table-5.1: {text}", lambda: run_file("drozdetskaya-2020/table-5.1", setting_of(text)))


NO_SETTINGS = {
    "no =": ("p1.mass", "KEY=VALUE"),
    "no key": ("=3", "KEY=VALUE"),
    "blank value": ("p1.mass=  ", "KEY=VALUE"),
    "brackets and their ends": (f"drive.slope={20_000 * '['}{20_000 * ']'}", "at most 40 brackets"),
    "digits": (f"drive.slope=[{5000 * '1'}]", "thousands of digits"),
    "parts": (f"{10_000 * 'a.'}a=1", "at most 40 parts"),
}


@pytest.mark.parametrize(("setting", "says"), NO_SETTINGS.values(), ids=NO_SETTINGS.keys())
def test_what_is_no_setting(refused: Refused, study: Study, setting: str, says: str) -> None:
    refused("run", study(), "-o", "out", "--json", "--set", setting, says=("--set", says))
    assert not Path("out").exists()


# Commands

USAGE = {
    "no study": (("run",), "study"),
    "unknown option": (("run", "a", "--jsn"), "--jsn"),
    "option without value": (("run", "a", "-o"), "-o"),
    "unknown command": (("rum",), "rum"),
    "no result": (("plot",), "result"),
    "unknown format": (("plot", "a", "--format", "gif"), "gif"),
    "no machine": (("equations",), "study"),
    "port": (("app", "--port", "70000"), "65535"),
}


@pytest.mark.parametrize(("words", "says"), USAGE.values(), ids=USAGE.keys())
def test_a_command_used_wrongly(refused: Refused, words: tuple[str, ...], says: str) -> None:
    refused(*words, says=(says,))


def test_new_overwrites_nothing(refused: Refused, wucht: Command, here: Path) -> None:
    Path("mine.toml").write_text("precious")
    refused("new", "run-up", "mine.toml", says=("given 'mine.toml'", "exists already"))
    assert Path("mine.toml").read_text() == "precious"
    Path("folder").mkdir()
    refused("new", "run-up", "folder", says=("given 'folder'", "exists already"))
    assert wucht("new", "run-up").code == 0
    refused("new", "run-up", says=("given 'run-up.toml'", "exists already"))


def test_control_characters_of_a_name_are_not_said(refused: Refused, here: Path) -> None:
    refused("run", "a\nb\x1b[1m.toml", says=("a?b?[1m.toml: ",))


def test_new_of_an_unknown_name(refused: Refused, here: Path) -> None:
    refused("new", "runup", says=("given 'runup'", "did you mean 'run-up'?"))
    refused("new", "../../etc/passwd", says=("must be a study or a catalogue name; `wucht list` prints all names",))
    refused("new", "run-up", 300 * "x", says=("xxx",))
    refused("run", 300 * "x" + ".toml", says=("xxx",))
    refused("new", "run-up", "nowhere/mine.toml", says=("given 'nowhere/mine.toml'", "written"))
    assert not list(Path().iterdir())


def test_new_on_stdout(wucht: Command, here: Path) -> None:
    assert wucht("new", "run-up", "mine.toml").code == 0
    assert wucht("new", "run-up", "-").out == Path("mine.toml").read_text(encoding="utf-8")
    assert wucht("--version").out == f"wucht {version}\n"


def test_plot_of_a_stranger(refused: Refused, here: Path) -> None:
    import xarray as xr

    data = {"a": ("time", [1.0, 2.0])}
    xr.Dataset(data).to_netcdf("other.nc", engine="h5netcdf")
    refused("plot", "other.nc", says=("other.nc: ", "not written by wucht"))
    xr.Dataset(data, attrs={"study": "run-up"}).to_netcdf("other.nc", engine="h5netcdf")
    refused("plot", "other.nc", says=("other.nc: summary", "missing"))
    Path("empty.nc").write_bytes(b"")
    refused("plot", "empty.nc", says=("empty.nc: ", "it is empty"))


def test_resume_of_a_damaged_result(refused: Refused, study: Study) -> None:
    Path("out").mkdir()
    Path("out/result.nc").write_bytes(b"damaged")
    refused("run", study(), "-o", "out", "--resume", says=("result.nc: ", "NetCDF"))
    assert Path("out/result.nc").read_bytes() == b"damaged"


# As JSON: one object on stdout, with the exit code and the sentence that stderr has

KEYS = {"error", "file", "key", "given", "allowed", "exit_code"}


def place(document: dict[str, Any]) -> tuple[Any, ...]:
    assert document.keys() == KEYS
    return tuple(document[k] for k in ("file", "key", "given", "exit_code"))


WRONG = {
    "a key of the study": (("run", "study.toml", "--set", "study.until=5 kg"), ("study.toml", "study.until", "'5 kg'")),
    "no such file": (("run", "none.toml"), ("none.toml", None, None)),
    "no catalogue name": (("run", "none"), (None, "FILE", "'none'")),
}


@pytest.mark.parametrize(("words", "expected"), WRONG.values(), ids=WRONG.keys())
def test_where_the_input_is_wrong(
    wucht: Command, study: Study, words: tuple[str, ...], expected: tuple[str | None, ...]
) -> None:
    study()
    done = wucht(*words, "--json")
    assert done.code == 2
    assert place(done.document) == (*expected, 2)
    assert done.document["allowed"] in done.document["error"]
    assert done.err == f"wucht: {done.document['error']}\n"
    assert not wucht(*words).out, "without --json stdout stays empty"


def test_the_file_is_that_which_is_wrong(wucht: Command, study: Study) -> None:
    study('"1 kg"', '"1 s"', name="base.toml")
    Path("top.toml").write_text('[machine]\nuse = "base.toml"\n')
    Path("middle.toml").write_text('[machine]\nuse = "top.toml"\n[study]\nkind = "run-up"\n')
    assert place(wucht("run", "middle.toml", "--json").document)[:2] == ("base.toml", "machine.carrier.mass")
    Path("base.toml").write_text("[machine")
    assert place(wucht("run", "middle.toml", "--json").document)[:2] == ("base.toml", None)


def test_usage_and_commands_without_the_option(wucht: Command) -> None:
    for words in (("run", "--json"), ("list", "--json", "--wrong"), ("walk", "--json")):
        done = wucht(*words)
        assert done.code == 2
        assert place(done.document) == (None, None, None, 2)
