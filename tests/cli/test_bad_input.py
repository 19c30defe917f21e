"""Everything that a user can get wrong: exit code 2, one sentence with file, key, what was given and what it must be."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Refused = Callable[..., str]
Study = Callable[..., Path]
Command = Callable[..., Any]

DRIVE = 'on = "drum"\nkind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"\n'
ROTOR = 'eccentricity = "1 mm"\n'
UNTIL = 'until = "0.5 s"'
START = '{ p1 = "0.3 rad", p2 = "-0.5 rad" }'
CARRIER = "[machine.carrier]"
MASS = '"9 kg"'
DRUM = "machine.bodies[0] (drum)"
P1 = "machine.bodies[1] (p1)"
HUGE = "1" + 400 * "0"


def _refuse(refused: Refused, study: Study, old: str, new: str, *says: str) -> None:
    file = study(old, new)
    refused("run", file, "-o", "out", "--json", says=("study.toml: ", *says))
    assert not Path("out").exists(), "a refused study leaves no folder behind"


UNKNOWN = {
    "file": ("title =", "titel =", "titel", "given 'A drum", "did you mean 'title'?", "known: ", "study"),
    "machine": (CARRIER, f"[machine]\nbodys = 1\n{CARRIER}", "machine.bodys", "given 1", "did you mean 'bodies'?"),
    "carrier": ("stiffness =", "stifness =", "machine.carrier.stifness", "given '1e5 N/m'", "did you mean 'stiffness'?"),
    "rotor": ("eccentricity", "excentricity", f"{DRUM}.excentricity", "given '1 mm'", "did you mean 'eccentricity'?"),
    "pendulum": ("length", "lenght", f"{P1}.lenght", "given '104 mm'", "did you mean 'length'?"),
    "drive": ("slope", "slop", "machine.drive.slop", "given '0.04 N m s'", "did you mean 'slope'?"),
    "study": ("until", "untill", "study.untill", "given '0.5 s'", "did you mean 'until'?"),
    "start": ("{ p1 =", "{ p3 =", "study.start.p3", "given '0.3 rad'", "did you mean 'p2'?"),
    "start of a body": ('p1 = "0.3 rad"', "p1 = { angel = 1 }", "study.start.p1.angel", "did you mean 'angle'?"),
    "start of the carrier": ('p1 = "0.3 rad"', "carrier = { z = 1 }", "study.start.carrier.z", "known: vx, vy, x, y"),
    "until": (UNTIL, "until = { turn = 3 }", "study.until.turn", "did you mean 'turns'?"),
    "kind of a body": ('kind = "rotor"', 'knid = "rotor"', f"{DRUM}.knid", "did you mean 'kind'?"),
    "kind of a drive": ('kind = "linear"', 'knid = "linear"', "machine.drive.knid", "did you mean 'kind'?"),
    "kind of a study": ('kind = "run-up"', 'knid = "run-up"', "study.knid", "did you mean 'kind'?"),
}


@pytest.mark.parametrize("case", UNKNOWN.values(), ids=UNKNOWN.keys())
def test_an_unknown_key_names_the_nearest(refused: Refused, study: Study, case: tuple[str, ...]) -> None:
    _refuse(refused, study, *case)


MISSING = {
    "kind of a body": ('kind = "rotor"\n', f"{DRUM}.kind", "known: pendulum, roller, rotor"),
    "name": ('name = "drum"\n', "machine.bodies[0].name", "missing"),
    "mass": ('mass = "9 kg"\n', f"{DRUM}.mass", "missing", "mass in kg"),
    "unbalance": ('eccentricity = "1 mm"\n', f"{DRUM}.eccentricity", "either eccentricity or unbalance"),
    "inertia": ('inertia = "0.03 kg m^2"\n', f"{DRUM}.inertia", "missing", "kg m^2"),
    "stiffness": ('stiffness = "1e5 N/m"\n', "machine.carrier.stiffness", "missing", "N/m"),
    "about": ('about = "drum"\n', f"{P1}.about", "missing"),
    "length": ('length = "104 mm"\n', f"{P1}.length", "missing", "length in m"),
    "slope": ('slope = "0.04 N m s"\n', "machine.drive.slope", "missing", "N m s"),
    "no-load speed": ('no_load_speed = "200 rad/s"\n', "machine.drive.no_load_speed", "missing", "rad/s"),
    "kind of a drive": ('kind = "linear"\n', "machine.drive.kind", "missing", "known: constant-speed, constant-torque"),
    "kind of a study": ('kind = "run-up"\n', "study.kind", "missing", "run-up"),
    "drive": ("[machine.drive]\n" + DRIVE, "machine.drive", "neither a drive nor an initial speed"),
}


@pytest.mark.parametrize("case", MISSING.values(), ids=MISSING.keys())
def test_a_missing_key_is_named(refused: Refused, study: Study, case: tuple[str, ...]) -> None:
    gone, *says = case
    _refuse(refused, study, gone, "", *says)


VALUES = {
    # what was given is told as it was written
    "dimension": ('"104 mm"', '"3 kg"', f"{P1}.length", "given '3 kg'", "must be a length", "m", "this one is a mass"),
    "dimension of a time": (UNTIL, 'until = "3 kg"', "study.until", "given '3 kg'", "must be a time", "mass"),
    "dimension in a pair": ('"1e5 N/m"', '["1 N/m", "1 kg"]', "machine.carrier.stiffness", "stiffness", "mass"),
    "unknown unit": (MASS, '"9 kilopound_x"', f"{DRUM}.mass", "given '9 kilopound_x'", "must be a mass"),
    "no quantity": (MASS, '"heavy"', f"{DRUM}.mass", "given 'heavy'", "must be a mass"),
    "no quantity at all": (MASS, '"9 kg kg) ("', f"{DRUM}.mass", "must be a mass"),
    "negative mass": (MASS, '"-9 kg"', f"{DRUM}.mass", "given '-9 kg'", "greater than 0 kg"),
    "no mass": (MASS, "0", f"{DRUM}.mass", "given 0;", "greater than 0 kg"),
    "negative length": ('"104 mm"', '"-104 mm"', f"{P1}.length", "given '-104 mm'", "greater than 0 m"),
    "negative carrier": ('"1 kg"', '"-1 kg"', "machine.carrier.mass", "given '-1 kg'", "at least 0 kg"),
    "negative stiffness": ('"1e5 N/m"', "-1", "machine.carrier.stiffness", "given -1", "at least 0"),
    "negative stiffness in y": ('"1e5 N/m"', "[1, -1]", "machine.carrier.stiffness", "given [1, -1]", "at least 0"),
    "negative damping": ('"200 N s/m"', "-1", "machine.carrier.damping", "given -1", "at least 0"),
    "negative slope": ('"0.04 N m s"', "-1", "machine.drive.slope", "given -1", "at least 0"),
    "least inertia of a rotor": ('"0.03 kg m^2"', "8.9e-6", f"{DRUM}.inertia", "given 8.9e-06", "at least m e^2 = 9e-06"),
    "least inertia of a pendulum": (
        'length = "104 mm"', 'length = "104 mm"\ninertia = 1e-9', f"{P1}.inertia", "given 1e-09", "at least m l^2 = 0.001352",
    ),
    "roller in its track": (
        'kind = "pendulum"\nname = "p1"\nabout = "drum"\nmass = "125 g"\nlength = "104 mm"',
        'kind = "roller"\nname = "p1"\nabout = "drum"\nmass = "125 g"\ntrack_radius = 0.1\nradius = 0.2',
        f"{P1}.radius", "given 0.2", "less than the track radius of 0.1 m",
    ),
    "far too large": ('"1 mm"', "1e300", f"{DRUM}.", "must be"),
    "far too long": ('"104 mm"', "1e300", "study.toml: machine"),
    "beyond all numbers": ('"1e5 N/m"', "1e308", "machine.carrier.stiffness", "a stiffness of at most 1e+30 N/m"),
    "beyond all numbers below": ('"200 rad/s"', "-1e308", "machine.drive.no_load_speed", "of at least -1e+30 rad/s"),
    "a start beyond all numbers": (START, "{ drum = { speed = 1e308 } }", "study.start.drum.speed", "at most 1e+30 rad/s"),
    "a mass of all but nothing": (MASS, "1e-320", f"{DRUM}.mass", "greater than 0 kg, and of at least 1e-30 kg"),
    "a date": ('"0.3 rad"', "1979-05-27", "study.start.p1.angle", "given 1979-05-27; must be an angle"),
    "points beyond all numbers": (
        DRIVE, 'on = "drum"\nkind = "table"\npoints = [[0, 1e308], [1, -1e308]]\n', "machine.drive.points", "at most 1e+30 N m",
    ),
    "NUL in a text": ('"A drum with two pendulums"', '"a\\u0000b"', "title", "given 'a\\x00b'"),
    "two unbalances": (ROTOR, f"{ROTOR}unbalance = 1e-3\n", f"{DRUM}.eccentricity", "either eccentricity or unbalance"),
    "weight without a spring": ('"1e5 N/m"', "0\ngravity = 9.81", "machine.carrier.stiffness", "positive stiffness in y"),
    "pair in one direction": ('"1e5 N/m"', '[1, 2]\ndirections = "x"', "machine.carrier.stiffness", "one number"),
    # names
    "one name twice": ('"p2"', '"p1"', "machine.bodies", "given 'p1'", "two bodies have this name"),
    "about nothing": ('about = "drum"', 'about = "dram"', f"{P1}.about", "given 'dram'", "did you mean 'drum'?"),
    "about itself": ('about = "drum"', 'about = "p1"', f"{P1}.about", "given 'p1'", "circle"),
    "drive on nothing": ('on = "drum"', 'on = "dram"', "machine.drive.on", "given 'dram'", "did you mean 'drum'?"),
    "name taken": ('name = "p2"', 'name = "carrier"', "machine.bodies[2].name", "given 'carrier'", "reserved"),
    "name with a dot": ('name = "drum"', 'name = "a.b"', ".name", "given 'a.b'", "letters, digits"),
    "name with a space": ('name = "drum"', 'name = "a b"', ".name", "given 'a b'", "letters, digits"),
    "name of two lines": ('name = "drum"', 'name = "drum\\n"', ".name", "given 'drum\\n'", "letters, digits"),
    "empty name": ('name = "drum"', 'name = ""', ".name", "given ''", "letters, digits"),
    # kinds
    "kind of a body": ('kind = "rotor"', 'kind = "roter"', f"{DRUM}.kind", "given 'roter'", "did you mean 'rotor'?"),
    "kind of a drive": ('kind = "linear"', 'kind = "liner"', "machine.drive.kind", "given 'liner'", "did you mean 'linear'?"),
    "kind of a study": ('kind = "run-up"', 'kind = "runup"', "study.kind", "given 'runup'", "did you mean 'run-up'?"),
    "directions": ('mass = "1 kg"', 'directions = "z"', "machine.carrier.directions", "given 'z'", "fixed, r, x, xy, xyr, y"),
    "model": (UNTIL, f'{UNTIL}\nmodel = "fulll"', "study.model", "given 'fulll'", "must be 'full'"),
    "order": (UNTIL, f'{UNTIL}\nmodel = "slow"\norder = 3', "study.order", "given 3", "must be 1 or 2"),
    "order in words": (UNTIL, f'{UNTIL}\nmodel = "slow"\norder = "second"', "study.order", "given 'second'"),
    "order of the full model": (UNTIL, f"{UNTIL}\norder = 2", "study.order", "given 2", "'slow' or 'both'"),
    "inertia": (UNTIL, f'{UNTIL}\nmodel = "both"\ninertia = 1', "study.inertia", "given 1", "true or false"),
    "inertia of the full model": (UNTIL, f"{UNTIL}\ninertia = true", "study.inertia", "'slow' or 'both'"),
    "models": (UNTIL, f'{UNTIL}\nmodel = ["full", "slow"]', "study.model", "must be 'full'"),
    "engine": (UNTIL, f'{UNTIL}\nengine = "heyokka"', "study.engine", "given 'heyokka'", "'compiled' or 'radau'"),
    # times
    "negative time": (UNTIL, "until = -1", "study.until", "given -1", "greater than 0"),
    "no time": (UNTIL, 'until = "0 s"', "study.until", "given '0 s'", "greater than 0"),
    "negative turns": (UNTIL, "turns = -3", "study.turns", "given -3", "greater than 0"),
    "no turns": (UNTIL, "turns = 0", "study.turns", "given 0", "greater than 0"),
    "turns with a unit": (UNTIL, 'turns = "3 m"', "study.turns", "given '3 m'", "without unit", "length"),
    "never": (UNTIL, "settled = false", "study.settled", "given False"),
    "until nothing": (UNTIL, "until = {}", "study.until"),
    "tolerance 0": (UNTIL, f"{UNTIL}\ntolerance = 0", "study.tolerance", "given 0"),
    "tolerance below 0": (UNTIL, f"{UNTIL}\ntolerance = -1e-9", "study.tolerance", "given -1e-09"),
    "tolerance 1": (UNTIL, f"{UNTIL}\ntolerance = 1", "study.tolerance", "given 1", "0.01"),
    "tolerance with a unit": (UNTIL, f'{UNTIL}\ntolerance = "1 kg"', "study.tolerance", "without unit", "mass"),
    "speed limit 0": (UNTIL, f"{UNTIL}\nspeed_limit = 0", "study.speed_limit", "given 0", "greater than 0"),
    "until and turns": (UNTIL, f"{UNTIL}\nturns = 3", "study.", "one of until, turns and settled"),
    "until and settled": (UNTIL, f"{UNTIL}\nsettled = true", "study.", "one of until, turns and settled"),
    "turns and settled": (UNTIL, "turns = 3\nsettled = true", "study.", "one of until, turns and settled"),
    "all three": (UNTIL, f"{UNTIL}\nturns = 3\nsettled = true", "study.", "one of until, turns and settled"),
    # start
    "start in kg": (START, '{ p1 = "3 kg" }', "study.start.p1", "given '3 kg'", "angle", "mass"),
    "start speed in kg": (START, '{ p1 = { speed = "3 kg" } }', "study.start.p1.speed", "given '3 kg'", "speed", "mass"),
    "start of the carrier in rad": (START, '{ carrier = { x = "1 kg" } }', "study.start.carrier.x", "displacement", "mass"),
    "psi beside p1": (START, "{ psi = 1, p1 = 2 }", "study.start.p1", "either psi and delta"),
    # drives
    "both drive and drives": (
        "[machine.drive]", f"[[machine.drives]]\n{DRIVE}[machine.drive]", "machine.drives", "either",
    ),
    "two drives on one body": (f"[machine.drive]\n{DRIVE}", 2 * f"[[machine.drives]]\n{DRIVE}", "drives", "given 'drum'"),
    # models and use beside parts
    "model beside parts": (CARRIER, f'[machine]\nmodel = "laval-rotor"\n{CARRIER}', "machine.carrier", "'laval-rotor'"),
    "unknown model": (CARRIER, f'[machine]\nmodel = "lavalrotor"\n{CARRIER}', "machine.model", "did you mean 'laval-rotor'?"),
    "parameters beside parts": (CARRIER, f"[machine.parameters]\nu = 1\n{CARRIER}", "machine.parameters", "model"),
    "use beside parts": (CARRIER, f'[machine]\nuse = "drozdetskaya-2020/r1"\n{CARRIER}', "machine.", "not allowed beside use"),
    "set of a body that is not there": (
        CARRIER, f'[machine]\nset = {{ "p3.mass" = 1 }}\n{CARRIER}', "machine.set.p3.mass", "did you mean 'p2'?",
    ),
    "set of a key that is not there": (
        CARRIER, f'[machine]\nset = {{ "p1.masss" = 1 }}\n{CARRIER}', "p1", "masss", "did you mean 'mass'?",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", VALUES.values(), ids=VALUES.keys())
def test_a_wrong_value_is_told_with_what_is_allowed(refused: Refused, study: Study, case: tuple[str, ...]) -> None:
    _refuse(refused, study, *case)


def test_two_bodies_about_each_other(refused: Refused, study: Study) -> None:
    file = study('about = "drum"', 'about = "p2"', 'about = "drum"', 'about = "p1"')
    refused("run", file, says=("study.toml: machine.bodies[1] (p1).about", "given 'p2'", "circle"))


def test_the_start_of_a_prescribed_body_is_the_drives(refused: Refused, study: Study) -> None:
    file = study(DRIVE, 'kind = "constant-speed"\nspeed = 100\n', 'p1 = "0.3 rad"', "drum = 1")
    refused("run", file, "--json", says=("study.toml: ", "study.start.drum", "given 1", "the drive"))


def test_a_speed_limit_on_a_prescribed_speed_is_answered(wucht: Command, study: Study) -> None:
    file = study(DRIVE, 'kind = "constant-speed"\nspeed = 100\n', UNTIL, f"{UNTIL}\nspeed_limit = 50")
    completed = wucht("run", file, "-o", "out", "--json")
    assert completed.code == 2 or completed.document["summary"]["outcome"] == "runaway"


NOT_FINITE = ("nan", "inf", "-inf", '"nan kg"', '"inf kg"', '"-inf kg"', "1e400", '"1e400"', '"1e400 kg"', HUGE, f'"{HUGE} kg"')


@pytest.mark.parametrize("value", NOT_FINITE, ids=lambda v: v[:10])
@pytest.mark.parametrize(
    ("old", "key"),
    [(MASS, "mass"), ('"0.5 s"', "study.until"), ('"0.3 rad"', "study.start.p1")],
    ids=["mass", "until", "start"],
)
def test_numbers_must_be_finite(refused: Refused, study: Study, value: str, old: str, key: str) -> None:
    completed = refused("run", study(old, value), "--json", says=("study.toml: ", key, "given "))
    assert len(completed) < 500


# What looks like a quantity and is none: never to be computed, or to be read as another number.
NO_QUANTITIES = {
    "decimal comma": "1,5 kg",
    "thousands apart": "1 000 kg",
    "two points": "1.5.2 kg",
    "two quantities": "1 kg; 2 kg",
    "a sum of two kinds": "1 kg + 1 m",
    "a difference": "1 kg-m",
    "a power": "9**9 kg",
    "unit alone": "kg",
    "sign alone": "-kg",
    "call": "__import__('os')",
    "percent": "5 %",
    "temperature": "5 degC",
    "hexadecimal": "0x10 kg",
    "complex": "1j kg",
    "brackets": 3000 * "(" + "1 kg",
}


@pytest.mark.parametrize("value", NO_QUANTITIES.values(), ids=NO_QUANTITIES.keys())
def test_what_only_looks_like_a_quantity(refused: Refused, study: Study, value: str) -> None:
    completed = refused("run", study(MASS, f'"{value}"'), "--json", says=("study.toml: ", f"{DRUM}.mass", "must be a mass"))
    assert len(completed) < 500


WRONG_TYPES = ("true", "[1]", "{ a = 1 }", "1979-05-27", '""', '"  "')
PLACES = {
    "mass": (MASS, f"{DRUM}.mass"),
    "until": ('"0.5 s"', "study.until"),
    "slope": ('"0.04 N m s"', "machine.drive.slope"),
    "start": ('"0.3 rad"', "study.start.p1"),
}


@pytest.mark.parametrize("value", WRONG_TYPES)
@pytest.mark.parametrize(("old", "key"), PLACES.values(), ids=PLACES.keys())
def test_a_number_is_a_number(refused: Refused, study: Study, value: str, old: str, key: str) -> None:
    refused("run", study(old, value), "--json", says=("study.toml: ", key))


@pytest.mark.parametrize("value", ["[1]", "[1, 2, 3]", "[]", '["1 N/m", "2 kg"]', "[[1], [2]]", "[true, false]"])
def test_a_pair_is_a_pair(refused: Refused, study: Study, value: str) -> None:
    refused("run", study('"1e5 N/m"', value), "--json", says=("study.toml: ", "machine.carrier.stiffness", "given ", "must be"))


NAMES = {
    "name": ('"drum"', ".name"),
    "about": ('about = "drum"', f"{P1}.about"),
    "kind of a body": ('kind = "rotor"', f"{DRUM}.kind"),
    "kind of a drive": ('kind = "linear"', "machine.drive.kind"),
    "kind of a study": ('kind = "run-up"', "study.kind"),
    "on": ('on = "drum"', "machine.drive.on"),
    "title": ('title = "A drum with two pendulums"', "title"),
}


@pytest.mark.parametrize("value", ["3", "true", '["drum"]', "{ a = 1 }", '""', "1.5"])
@pytest.mark.parametrize(("old", "key"), NAMES.values(), ids=NAMES.keys())
def test_a_name_is_a_text(refused: Refused, study: Study, value: str, old: str, key: str) -> None:
    head = f"{old.split(' = ', maxsplit=1)[0]} = " if " = " in old else ""
    refused("run", study(old, head + value), "--json", says=("study.toml: ", key))


TABLES = {
    "machine": ("machine = 'x'\n", "machine"),
    "machine a list": ("[[machine]]\n", "machine"),
    "no machine": ("[study]\nkind = 'run-up'\n", "machine"),
    "nothing": ("", "machine"),
    "machine empty": ("[machine]\n", "machine.carrier"),
    "carrier": ("machine = { carrier = 'x' }\n", "machine.carrier"),
    "carrier a list": ("machine = { carrier = [1] }\n", "machine.carrier"),
    "bodies a text": ("[machine]\nbodies = 'x'\ncarrier = { stiffness = 1 }\n", "machine.bodies"),
    "bodies a table": ("[machine]\nbodies = { kind = 'rotor' }\ncarrier = { stiffness = 1 }\n", "machine.bodies"),
    "bodies numbers": ("[machine]\nbodies = [1]\ncarrier = { stiffness = 1 }\n", "machine.bodies"),
    "no bodies": ("[machine]\nbodies = []\ncarrier = { stiffness = 1 }\n", "machine.bodies"),
    "set a text": ("[machine]\nset = 'x'\ncarrier = { stiffness = 1 }\n", "machine.set"),
    "set a list": ("[machine]\nset = [1]\ncarrier = { stiffness = 1 }\n", "machine.set"),
    "set beside use": ("[machine]\nuse = 'drozdetskaya-2020/r1'\nset = 'x'\n", "machine.set"),
    "parameters": ("[machine]\nmodel = 'laval-rotor'\nparameters = 'x'\n", "machine.parameters"),
    "parameters that are set": ("[machine]\nmodel = 'laval-rotor'\nparameters = 'x'\nset = { u = 1 }\n", "machine.parameters"),
    "parameters a list": ("[machine]\nmodel = 'laval-rotor'\nparameters = [1]\nset = { u = 1 }\n", "machine.parameters"),
    "no parameters": ("[machine]\nmodel = 'laval-rotor'\n", "machine.parameters"),
    "model a list": ("[machine]\nmodel = ['laval-rotor']\n", "machine.model"),
    "model a table": ("[machine]\nmodel = { a = 1 }\n", "machine.model"),
    "use a number": ("[machine]\nuse = 3\n", "machine.use"),
    "use a list": ("[machine]\nuse = ['a']\n", "machine.use"),
    "use empty": ("[machine]\nuse = ''\n", "machine.use"),
    "study a text": ("study = 'x'\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study"),
    "study a list": ("[[study]]\nkind = 'run-up'\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study"),
    "start a list": ("[study]\nkind = 'run-up'\nstart = [1]\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study.start"),
    "start a number": ("[study]\nkind = 'run-up'\nstart = 1\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study.start"),
    "settled 1": ("[study]\nkind = 'run-up'\nsettled = 1\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study.settled"),
    "settled 0": ("[study]\nkind = 'run-up'\nsettled = 0\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study.settled"),
    "settled a text": ("[study]\nkind = 'run-up'\nsettled = 'yes'\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study.settled"),
    "model of a study a list": (
        "[study]\nkind = 'run-up'\nmodel = ['slow']\n[machine]\nuse = 'drozdetskaya-2020/r1'\n", "study.model",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "key"), TABLES.values(), ids=TABLES.keys())
def test_a_table_is_a_table(refused: Refused, here: Path, text: str, key: str) -> None:
    Path("study.toml").write_text(text)
    refused("run", "study.toml", "--json", says=(f"study.toml: {key}",))


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


def test_a_used_file_that_is_not_there(refused: Refused, here: Path) -> None:
    Path("study.toml").write_text('[machine]\nuse = "other.toml"\n')
    refused("run", "study.toml", "--json", says=("study.toml: machine.use", "other.toml", "there is no such file"))
    Path("study.toml").write_text('[machine]\nuse = "drozdetskaya-2020/table-5.2"\n')
    refused("run", "study.toml", says=("study.toml: machine.use", "table-5.2", "did you mean 'drozdetskaya-2020/table-5.1',"))


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


@pytest.mark.parametrize(
    "key", ["model = 'laval-rotor'", "bodies = []", "parameters = {}", "carrier = {}", "drive = {}", "x = 1"]
)
def test_nothing_stands_beside_use(refused: Refused, here: Path, key: str) -> None:
    Path("study.toml").write_text(f'[machine]\nuse = "drozdetskaya-2020/r1"\n{key}\n')
    refused("run", "study.toml", says=("study.toml: ", f"machine.{key.split(maxsplit=1)[0]}", "use", "set"))


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

SETTINGS = {
    "no =": ("p1.mass", "--set", "given 'p1.mass'", "KEY=VALUE"),
    "no key": ("=3", "--set", "given '=3'", "KEY=VALUE"),
    "no value": ("p1.mass=", "--set", "given 'p1.mass='", "KEY=VALUE"),
    "blank value": ("p1.mass=  ", "--set", "KEY=VALUE"),
    "a part alone": ("p1=3", "p1", "given 3", "this is a part; set one of its keys as p1.KEY: about, damping, "),
    "a table of nothing": ("bogus={}", "machine.set.bogus", "given {}", "unknown parameter"),
    "a table of nothing in the study": ("study.bogus={}", "study.bogus", "given {}", "unknown key"),
    "brackets": (f"drive.slope={20_000 * '['}", "--set drive.slope: given", "at most 40 brackets are nested"),
    "brackets and their ends": (f"drive.slope={20_000 * '['}{20_000 * ']'}", "--set", "at most 40 brackets are nested"),
    "tables": ("drive.slope=" + 20_000 * '{"a":', "--set", "at most 40 brackets are nested"),
    "digits": (f"drive.slope=[{5000 * '1'}]", "--set drive.slope: given", "a number of thousands of digits"),
    "a key of many parts": (f"{10_000 * 'a.'}a=1", "--set", "at most 40 parts"),
    "a key of many parts in the study": (f"study.{10_000 * 'a.'}a=1", "--set", "at most 40 parts"),
    "beyond all numbers": ("study.until=1e300", "study.until", "a time of at most 1e+30 s"),
    "all but nothing": ("study.until=1e-320", "study.until", "greater than 0 s, and of at least 1e-30 s"),
    "unknown body": ("p3.mass=1", "p3.mass", "given 1", "did you mean 'p2'?"),
    "no body": ("mass=1", "mass", "known: carrier, drive, drum, p1, p2"),
    "unknown key": ("p1.masss=1", "p1", "masss", "given 1", "did you mean 'mass'?"),
    "empty key": ("p1..mass=1", "p1..mass"),
    "a dot": (".=3", "unknown parameter"),
    "machine": ("machine.p1.mass=1", "machine.p1.mass", "unknown parameter"),
    "bodies": ("bodies=3", "bodies", "unknown parameter"),
    "drives of one drive": ("drives.drum.slope=1", "drives.drum.slope", "did you mean 'drive"),
    "dimension": ("drive.slope=3 kg", "machine.drive.slope", "given '3 kg'", "mass"),
    "no quantity": ("drive.slope=abc", "machine.drive.slope", "given 'abc'"),
    "NaN": ("drive.slope=nan", "drive.slope", "given nan", "finite"),
    "infinite": ("drive.slope=1e400", "drive.slope", "finite"),
    "bool": ("drive.slope=true", "drive.slope", "given True"),
    "list": ("drive.slope=[1, 2]", "drive.slope", "given [1, 2]"),
    "list with NaN": ("carrier.stiffness=[NaN, 1]", "carrier.stiffness", "given [nan, 1]", "finite"),
    "table": ('drive.slope={"a": 1}', "drive.slope", "given "),
    "empty table": ("drive.slope={}", "drive.slope", "given {}"),
    "broken list": ("drive.slope=[", "drive.slope", "given '['"),
    "negative": ("p1.mass=-1", "p1", "mass", "given -1", "greater than 0"),
    "kind": ('p1.kind=["rotor"]', "p1", "kind"),
    "a name twice": ("p1.name=p2", "given 'p2'", "two bodies"),
    "component of a scalar": ("p1.mass.x=1", "p1.mass.x"),
    "third component": ("carrier.stiffness.z=1", "carrier.stiffness.z", "given 1"),
    "study": ("study=3", "study", "given 3"),
    "study without key": ("study.=3", "study.", "given 3"),
    "unknown key of the study": ("study.untill=3", "study.untill", "given 3", "did you mean 'until'?"),
    "until in kg": ("study.until=3 kg", "study.until", "given '3 kg'", "mass"),
    "until negative": ("study.until=-1", "study.until", "given -1"),
    "until NaN": ("study.until=nan", "study.until", "given nan"),
    "until nothing": ("study.until={}", "study.until"),
    "settled": ("study.settled=yes", "study.settled", "given 'yes'"),
    "kind of the study": ("study.kind=exciter-desing", "study.kind", "did you mean 'exciter-design'?"),
    "kind of the study a list": ('study.kind=["a"]', "study.kind"),
    "start of nothing": ("study.start.p3=1", "study.start.p3", "did you mean 'p2'?"),
    "start a number": ("study.start=3", "study.start", "given 3"),
    "start too deep": ("study.start.p1.x.y=3", "study.start.p1.x"),
    "start NaN": ('study.start={"p1": NaN}', "study.start.p1"),
}


@pytest.mark.parametrize("case", SETTINGS.values(), ids=SETTINGS.keys())
def test_a_wrong_setting(refused: Refused, study: Study, case: tuple[str, ...]) -> None:
    setting, *says = case
    refused("run", study(), "-o", "out", "--json", "--set", setting, says=tuple(says))
    assert not Path("out").exists()


def test_a_setting_of_a_dimensionless_machine(refused: Refused) -> None:
    name = "drozdetskaya-2020/table-5.1"
    refused("run", name, "--set", "v=1", says=("v", "given 1", "known: beta_p"))
    refused("run", name, "--set", "drive.slope=1", says=("drive.slope", "known: beta_p"))
    refused("run", name, "--set", "u=1 kg", says=("u", "given '1 kg'", "without unit"))
    refused("run", name, "--set", "mu=0", says=("mu", "given 0", "greater than 0"))


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
