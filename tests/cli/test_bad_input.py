"""Everything that a user can get wrong: one sentence with file, key, what was given and what it must be, and exit code 2.

The sentences are in ``tests/stated/refusals.json``.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.conftest import STUDY
from tests.refusals import cases_of, check_file, check_refusal

from wucht import run_file

Refused = Callable[..., str]
Study = Callable[..., Path]
Command = Callable[..., Any]

DRIVE = 'on = "drum"\nkind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"\n'
UNTIL = 'until = "0.5 s"'
CARRIER = "[machine.carrier]"
HUGE = "1" + 400 * "0"
P1 = 'kind = "pendulum"\nname = "p1"\nabout = "drum"\nmass = "125 g"\nlength = "104 mm"'
ROLLER = 'kind = "roller"\nname = "p1"\nabout = "drum"\nmass = "125 g"\ntrack_radius = 0.1\nradius = 0.2'

# What stands in the place of a text of the study file. Nothing: a key is missing.
CHANGES = {
    # keys
    "title =": ["titel ="], "stiffness =": ["stifness ="], "eccentricity": ["excentricity"], "length": ["lenght"],
    "slope": ["slop"], "until": ["untill"], "{ p1 =": ["{ p3 ="],
    'p1 = "0.3 rad"': ["p1 = { angel = 1 }", "carrier = { z = 1 }"],
    'mass = "9 kg"\n': [""], 'inertia = "0.03 kg m^2"\n': [""], 'stiffness = "1e5 N/m"\n': [""], 'about = "drum"\n': [""],
    'length = "104 mm"\n': [""], 'slope = "0.04 N m s"\n': [""], 'no_load_speed = "200 rad/s"\n': [""],
    'eccentricity = "1 mm"\n': ["", 'eccentricity = "1 mm"\nunbalance = 1e-3\n'],
    # kinds and names
    'kind = "rotor"': ["", 'knid = "rotor"', 'kind = "roter"'], 'kind = "linear"': ["", 'knid = "linear"', 'kind = "liner"'],
    'kind = "run-up"': ["", 'knid = "run-up"', 'kind = "runup"'], 'about = "drum"': ['about = "dram"', 'about = "p1"'],
    'on = "drum"': ['on = "dram"'], 'name = "p2"': ['name = "carrier"', 'name = "p1"'],
    'name = "drum"': ["", 'name = "a.b"', 'name = "a b"', 'name = "drum\\n"', 'name = ""'],
    # quantities
    '"104 mm"': ['"3 kg"', '"-104 mm"', "1e300"],
    '"1e5 N/m"': [
        '["1 N/m", "1 kg"]', "-1", "[1, -1]", "1e308", "0\ngravity = 9.81", '[1, 2]\ndirections = "x"',
        "[1]", "[1, 2, 3]", "[]", '["1 N/m", "2 kg"]', "[[1], [2]]", "[true, false]",
    ],
    '"9 kg"': ['"9 kilopound_x"', '"heavy"', '"9 kg kg) ("', '"-9 kg"', "0", "1e-320"],
    '"1 kg"': ['"-1 kg"'], '"200 N s/m"': ["-1"], '"0.04 N m s"': ["-1"], '"0.03 kg m^2"': ["8.9e-6"], '"1 mm"': ["1e300"],
    'length = "104 mm"': ['length = "104 mm"\ninertia = 1e-9'], P1: [ROLLER], '"200 rad/s"': ["-1e308"],
    '"0.3 rad"': ["1979-05-27"],
    '"A drum with two pendulums"': ['"a\\u0000b"'], 'mass = "1 kg"': ['directions = "z"'],
    # the question
    UNTIL: [
        "until = { turn = 3 }", 'until = "3 kg"', "until = -1", 'until = "0 s"', "until = {}", "turns = -3", "turns = 0",
        'turns = "3 m"', "settled = false", "turns = 3\nsettled = true",
        *(
            f"{UNTIL}\n{more}"
            for more in (
                'model = "fulll"', 'model = "slow"\norder = 3', 'model = "slow"\norder = "second"', "order = 2",
                'model = "both"\ninertia = 1', "inertia = true", 'model = ["full", "slow"]', 'engine = "heyokka"',
                "tolerance = 0",
                "tolerance = -1e-9", "tolerance = 1", 'tolerance = "1 kg"', "speed_limit = 0", "turns = 3", "settled = true",
                "turns = 3\nsettled = true",
            )
        ),
    ],
    '{ p1 = "0.3 rad", p2 = "-0.5 rad" }': [
        "{ drum = { speed = 1e308 } }", '{ p1 = "3 kg" }', '{ p1 = { speed = "3 kg" } }', '{ carrier = { x = "1 kg" } }',
        "{ psi = 1, p1 = 2 }",
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
# What looks like a quantity and is none: never to be computed, or to be read as another number.
NO_QUANTITIES = [
    "1,5 kg", "1 000 kg", "1.5.2 kg", "1 kg; 2 kg", "1 kg + 1 m", "1 kg-m", "9**9 kg", "kg", "-kg", "__import__('os')", "5 %",
    "5 degC", "0x10 kg", "1j kg", 3000 * "(" + "1 kg",
]  # fmt: skip
NOT_FINITE = ["nan", "inf", "-inf", '"nan kg"', '"inf kg"', '"-inf kg"', "1e400", '"1e400"', '"1e400 kg"', HUGE, f'"{HUGE} kg"']
WRONG_TYPES = ["true", "[1]", "{ a = 1 }", "1979-05-27", '""', '"  "']
NO_NAMES = ["3", "true", '["drum"]', "{ a = 1 }", '""', "1.5"]
NAMES = ["name", "about", "kind", "on", "title"]
GIVEN = {"kind": ["rotor", "linear", "run-up"], "title": ["A drum with two pendulums"]}
WRONG = {
    '"9 kg"': [*NOT_FINITE, *(f'"{text}"' for text in NO_QUANTITIES), *WRONG_TYPES], '"0.5 s"': [*NOT_FINITE, *WRONG_TYPES],
    '"0.3 rad"': [*NOT_FINITE, *WRONG_TYPES], '"0.04 N m s"': WRONG_TYPES,
    **{f'{key} = "{was}"': [f"{key} = {x}" for x in NO_NAMES] for key in NAMES for was in GIVEN.get(key, ["drum"])},
}  # fmt: skip


@pytest.mark.parametrize(("old", "new"), [*cases_of(CHANGES), *cases_of(WRONG)])
def test_what_is_wrong_in_a_file(here: Path, old: str, new: str) -> None:
    check_file("study", STUDY, {old: new})


SPEED = 'kind = "constant-speed"\nspeed = 100\n'


def test_two_places_of_a_file(here: Path) -> None:
    """Bodies about each other; the start of a body whose speed is prescribed."""
    check_file("study", STUDY, {'about = "drum"': 'about = "p2"', '"p2"\nabout = "drum"': '"p2"\nabout = "p1"'})
    check_file("study", STUDY, {DRIVE: SPEED, 'p1 = "0.3 rad"': "drum = 1"})


def test_a_speed_limit_on_a_prescribed_speed_is_answered(wucht: Command, study: Study) -> None:
    file = study(DRIVE, SPEED, UNTIL, f"{UNTIL}\nspeed_limit = 50")
    completed = wucht("run", file, "-o", "out", "--json")
    assert completed.code == 2 or completed.document["summary"]["outcome"] == "runaway"


USED = "[machine]\nuse = 'drozdetskaya-2020/r1'\n"
WHOLE = [
    "", "machine = 'x'\n", "[[machine]]\n", "[study]\nkind = 'run-up'\n", "[machine]\n", "machine = { carrier = 'x' }\n",
    "machine = { carrier = [1] }\n",
    *(
        f"[machine]\n{key}\ncarrier = {{ stiffness = 1 }}\n"
        for key in (
            "bodies = 'x'", "bodies = { kind = 'rotor' }", "bodies = [1]", "bodies = []", "set = 'x'", "set = [1]",
            *(f"bodies = {bodies}\nset = {{ carrier.mass = 1 }}" for bodies in ("3", "'x'", "true", "{ a = 1 }")),
        )
    ),
    *(
        f"{USED}{key}\n"
        for key in (
            "set = 'x'", "model = 'laval-rotor'", "bodies = []", "parameters = {}", "carrier = {}", "drive = {}", "x = 1",
        )
    ),
    *(
        f"[machine]\nmodel = {model}\n"
        for model in (
            "'laval-rotor'", "['laval-rotor']", "{ a = 1 }", "'laval-rotor'\nparameters = 'x'",
            "'laval-rotor'\nparameters = 'x'\nset = { u = 1 }", "'laval-rotor'\nparameters = [1]\nset = { u = 1 }",
        )
    ),
    *(
        f"[machine]\nuse = {use}\n"
        for use in ("3", "['a']", "''", "'other.toml'", "'drozdetskaya-2020/table-5.2'", "'study.toml'")
    ),
    f"study = 'x'\n{USED}", f"[[study]]\nkind = 'run-up'\n{USED}",
    *(
        f"[study]\nkind = 'run-up'\n{key}\n{USED}"
        for key in ("start = [1]", "start = 1", "settled = 1", "settled = 0", "settled = 'yes'", "model = ['slow']")
    ),
]  # fmt: skip


@pytest.mark.parametrize("text", WHOLE)
def test_a_table_is_a_table(here: Path, text: str) -> None:
    check_file("whole", "", {"": text})


# Files


NO_STUDY_FILES = {
    "no TOML": (b"hello world", "not valid TOML", "line 1"),
    "binary": (bytes(range(256)), "UTF-8"),
    "UTF-16": ("title = 'x'".encode("utf-16"), "UTF-8"),
    "Latin-1": ("title = 'Gr\u00f6\u00dfe'".encode("latin-1"), "UTF-8"),
    "NUL": (b"title = '\0'", "not valid TOML"),
    "a key twice": (b"title = 'a'\ntitle = 'b'\n", "not valid TOML", "line 2"),
    "nested arrays": (b"a = " + 5000 * b"[", "not valid TOML"),
    "nested tables": (b"a = " + 5000 * b"{a = ", "not valid TOML"),
    "an endless number": (b"\na = 1" + 6000 * b"0", "not valid TOML: a number of thousands of digits (at line 2)"),
    "a key of many parts": (b"machine." + 3000 * b"a." + b"a = 1", "broken.toml: machine: at most 40 tables"),
    "tables of many parts": (b"[" + 3000 * b"a." + b"a]", "at most 40 tables"),
}


@pytest.mark.parametrize("case", NO_STUDY_FILES.values(), ids=NO_STUDY_FILES.keys())
def test_a_file_that_is_no_toml(refused: Refused, here: Path, case: tuple[Any, ...]) -> None:
    content, *says = case
    Path("broken.toml").write_bytes(content)
    for command in ("run", "equations"):
        refused(command, "broken.toml", says=("broken.toml: ", *says))


def test_a_file_that_is_not_there(refused: Refused) -> None:
    refused("run", "nowhere.toml", "--json", says=("nowhere.toml: ", "there is no such file"))
    refused("run", "a/b/nowhere.toml", says=("a/b/nowhere.toml: ", "there is no such file"))


def test_a_folder_for_a_file(refused: Refused, here: Path) -> None:
    Path("folder.toml").mkdir()
    Path("folder").mkdir()
    refused("run", "folder.toml", "--json", says=("folder.toml: ", "folder"))
    refused("run", "folder", "--json", says=("folder: ", "not a file"))
    refused("run", ".", "--json", says=("not a file",))
    refused("run", "", "--json")


def test_a_file_that_may_not_be_read(refused: Refused, study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    file = study()
    if os.access(file, os.R_OK) and hasattr(os, "geteuid") and os.geteuid() == 0:
        # The superuser reads everything: the system's answer is put in its place.
        for method in ("open", "read_text", "read_bytes"):
            monkeypatch.setattr(Path, method, _denied)
    else:
        file.chmod(0)
    refused("run", file, "--json", says=("study.toml: ", "cannot be read", "Permission denied"))


def _denied(path: Path, *_: object, **__: object) -> None:
    raise PermissionError(13, "Permission denied", str(path))


def test_a_name_that_is_too_long(refused: Refused) -> None:
    refused("run", 300 * "x", says=("xxx",))
    refused("run", 300 * "x" + ".toml", says=("xxx",))
    refused("new", "run-up", 300 * "x", says=("xxx",))


def test_an_unknown_catalogue_name(refused: Refused) -> None:
    refused(
        "run",
        "drozdetskaya-2020/table-5.2",
        "--json",
        says=("FILE: given", "did you mean 'drozdetskaya-2020/table-5.1',", "`wucht list` prints all names"),
    )
    refused(
        "run",
        "drozdetskaya-2020",
        says=("FILE: given 'drozdetskaya-2020'; must be a study or machine file, or a catalogue name",),
    )
    refused(
        "run",
        "practice/nothing",
        says=("given 'practice/nothing'; must be a study or machine file, or a catalogue name; `wucht",),
    )
    refused("equations", "practice/laundry", says=("did you mean 'practice/laundry-drum', 'practice/laundry-drum-friction',",))


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


@pytest.mark.parametrize("out", ["file", "file/below", "file/below/deep", 300 * "y"])
def test_a_folder_that_cannot_be_written(refused: Refused, study: Study, out: str) -> None:
    Path("file").write_text("I am a file")
    refused("run", study(), "-o", out, "--json", says=("-o", f"given '{out[:20]}", "written"))
    assert Path("file").read_text() == "I am a file"


@pytest.mark.parametrize("name", ["result.nc", "summary.json", "run-up.png"])
def test_a_folder_in_the_place_of_a_result(wucht: Command, study: Study, name: str) -> None:
    Path("out", name).mkdir(parents=True)
    completed = wucht("run", study(), "-o", "out", "--json")
    assert completed.code in (1, 2)
    assert name in completed.err
    assert completed.err.startswith("wucht: ")
    assert completed.document["exit_code"] == completed.code


# Settings

SETTINGS = [
    "p1=3", "bogus={}", "study.bogus={}", "study.until=1e300", "study.until=1e-320", "p3.mass=1", "mass=1", "p1.masss=1",
    "p1..mass=1", ".=3", "machine.p1.mass=1", "bodies=3", "drives.drum.slope=1", "drive.slope=3 kg", "drive.slope=abc",
    "drive.slope=nan", "drive.slope=1e400", "drive.slope=true", "drive.slope=[1, 2]", "carrier.stiffness=[NaN, 1]",
    'drive.slope={"a": 1}', "drive.slope={}", "drive.slope=[", "p1.mass=-1", 'p1.kind=["rotor"]', "p1.name=p2", "p1.mass.x=1",
    "carrier.stiffness.z=1", "study=3", "study.=3", "study.untill=3", "study.until=3 kg", "study.until=-1", "study.until=nan",
    "study.until={}", "study.settled=yes", "study.kind=exciter-desing", 'study.kind=["a"]', "study.start.p3=1", "study.start=3",
    "study.start.p1.x.y=3", 'study.start={"p1": NaN}',
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


@pytest.mark.parametrize("text", ["v=1", "drive.slope=1", "u=1 kg", "mu=0"])
def test_a_setting_of_a_dimensionless_machine(text: str) -> None:
    check_refusal(f"table-5.1: {text}", lambda: run_file("drozdetskaya-2020/table-5.1", setting_of(text)))


NO_SETTINGS = {
    "no =": ("p1.mass", "KEY=VALUE"), "no key": ("=3", "KEY=VALUE"), "no value": ("p1.mass=", "KEY=VALUE"),
    "blank value": ("p1.mass=  ", "KEY=VALUE"), "brackets": (f"drive.slope={20_000 * '['}", "at most 40 brackets"),
    "brackets and their ends": (f"drive.slope={20_000 * '['}{20_000 * ']'}", "at most 40 brackets"),
    "tables": ("drive.slope=" + 20_000 * '{"a":', "at most 40 brackets"),
    "digits": (f"drive.slope=[{5000 * '1'}]", "thousands of digits"), "parts": (f"{10_000 * 'a.'}a=1", "at most 40 parts"),
    "parts in the study": (f"study.{10_000 * 'a.'}a=1", "at most 40 parts"),
}  # fmt: skip


@pytest.mark.parametrize(("setting", "says"), NO_SETTINGS.values(), ids=NO_SETTINGS.keys())
def test_what_is_no_setting(refused: Refused, study: Study, setting: str, says: str) -> None:
    refused("run", study(), "-o", "out", "--json", "--set", setting, says=("--set", says))
    assert not Path("out").exists()


# Commands

USAGE = {
    "no study": (("run",), "study"),
    "two studies": (("run", "a", "b"), "b"),
    "unknown option": (("run", "a", "--jsn"), "--jsn"),
    "option without value": (("run", "a", "-o"), "-o"),
    "set without value": (("run", "a", "--set"), "--set"),
    "unknown command": (("rum",), "rum"),
    "no result": (("plot",), "result"),
    "unknown format": (("plot", "a", "--format", "gif"), "gif"),
    "no name": (("new",), "name"),
    "list of something": (("list", "x", "y"), "y"),
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


def test_new_on_stdout(wucht: Command, here: Path) -> None:
    assert wucht("new", "run-up", "mine.toml").code == 0
    said = wucht("new", "run-up", "-")
    assert (said.code, said.out, said.err) == (0, Path("mine.toml").read_text(encoding="utf-8"), "")
    assert [p.name for p in here.iterdir()] == ["mine.toml"]


def test_control_characters_of_a_name_are_not_said(refused: Refused, here: Path) -> None:
    refused("run", "a\nb\x1b[1m.toml", says=("a?b?[1m.toml: ",))


def test_new_where_nothing_can_be_written(refused: Refused, here: Path) -> None:
    Path("file").write_text("")
    refused("new", "run-up", "file/mine.toml", says=("given 'file/mine.toml'", "written"))
    refused("new", "run-up", "nowhere/mine.toml", says=("given 'nowhere/mine.toml'", "written"))


def test_new_of_an_unknown_name(refused: Refused, here: Path) -> None:
    refused("new", "runup", says=("given 'runup'", "did you mean 'run-up'?"))
    refused("new", "../../etc/passwd", says=("must be a study or a catalogue name; `wucht list` prints all names",))
    assert not list(Path().iterdir())


def test_equations_of_bad_input(refused: Refused, study: Study) -> None:
    refused("equations", study("slope =", "slop ="), says=("study.toml: machine.drive.slop", "did you mean 'slope'?"))
    refused("equations", study(), "--set", "p1.mass", says=("KEY=VALUE",))


NO_RESULTS = {"text": b"hello", "empty": b"", "half a signature": b"\x89HDF\r\n\x1a\n", "TOML": b"[machine]\n"}


@pytest.mark.parametrize("content", NO_RESULTS.values(), ids=NO_RESULTS.keys())
def test_plot_of_a_file_that_is_no_result(refused: Refused, here: Path, content: bytes) -> None:
    Path("result.nc").write_bytes(content)
    refused("plot", "result.nc", says=("result.nc: ", "NetCDF"))


def test_plot_of_nothing(refused: Refused, here: Path) -> None:
    Path("folder").mkdir()
    refused("plot", "nowhere.nc", says=("nowhere.nc: ", "there is no such file"))
    refused("plot", "folder", says=("folder/result.nc: ", "there is no such file"))
    refused("plot", os.devnull, says=(f"{os.devnull}: ", "this is not a file"))
    refused("plot", "")


def test_plot_of_a_stranger(refused: Refused, here: Path) -> None:
    import xarray as xr

    data = {"a": ("time", [1.0, 2.0])}
    xr.Dataset(data).to_netcdf("other.nc", engine="h5netcdf")
    refused("plot", "other.nc", says=("other.nc: ", "not written by wucht"))
    xr.Dataset(data, attrs={"study": "run-up"}).to_netcdf("other.nc", engine="h5netcdf")
    refused("plot", "other.nc", says=("other.nc: summary", "missing"))


def test_resume_of_a_damaged_result(refused: Refused, study: Study) -> None:
    Path("out").mkdir()
    Path("out/result.nc").write_bytes(b"damaged")
    refused("run", study(), "-o", "out", "--resume", says=("result.nc: ", "NetCDF"))
    assert Path("out/result.nc").read_bytes() == b"damaged"
