"""What can be wrong with carriers, bodies, drives, loads, tables, schedules and tracks: exit code 2 and one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Refused = Callable[..., str]
Command = Callable[..., Any]

SCREEN = """\
[machine.carrier]
directions = "xyr"
mass = "100 kg"
inertia = "20 kg m^2"
mounts = [
    { at = ["-0.5 m", "0 m"], stiffness = ["2e4 N/m", "4e4 N/m"], damping = ["100 N s/m", "200 N s/m"] },
    { at = ["0.5 m", "0 m"], stiffness = ["2e4 N/m", "4e4 N/m"] },
]

[[machine.bodies]]
kind = "rotor"
name = "e1"
mass = "5 kg"
unbalance = "0.1 kg m"
inertia = "0.02 kg m^2"
position = ["-0.3 m", "0.2 m"]

[[machine.bodies]]
kind = "rotor"
name = "e2"
mass = "5 kg"
unbalance = "0.1 kg m"
inertia = "0.02 kg m^2"
position = ["0.3 m", "0.2 m"]
release = { speed = "50 rad/s" }

[[machine.drives]]
on = "e1"
kind = "induction"
voltage = "230 V"
frequency = "50 Hz"
pole_pairs = 2
stator_resistance = "4 ohm"
rotor_resistance = "3 ohm"
stator_reactance = "5 ohm"
rotor_reactance = "5 ohm"
stator = "carrier"

[[machine.drives]]
on = "e2"
kind = "table"
file = "motor.csv"

[[machine.loads]]
on = "e1"
kind = "viscous"
coefficient = "0.001 N m s"

[[machine.loads]]
on = "e1"
kind = "coulomb"
torque = "0.05 N m"

[[machine.schedules]]
parameter = "drives.e1.voltage"
points = [["0 s", "0 V"], ["1 s", "230 V"]]

[study]
kind = "run-up"
until = "0.02 s"
"""
RING = """\
[machine.carrier]
directions = "xy"
mass = "10 kg"
stiffness = ["1e5 N/m", "2e5 N/m"]
foundation = { direction = "y", mass = "50 kg", stiffness = "1e6 N/m", damping = "500 N s/m" }
motion = { direction = "x", amplitude = "1 mm", frequency = "30 rad/s" }

[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = "9 kg"
eccentricity = "1 mm"
inertia = "0.03 kg m^2"

[[machine.bodies]]
kind = "pendulum"
name = "p1"
about = "drum"
mass = "100 g"
length = "100 mm"
track = "ring"
diameter = "20 mm"
restitution = 0.6

[[machine.bodies]]
kind = "roller"
name = "p2"
about = "drum"
mass = "100 g"
track_radius = "110 mm"
radius = "10 mm"
shape_factor = 0.4
track = "ring"

[[machine.bodies]]
kind = "slider"
name = "s1"
about = "drum"
radius = "50 mm"
mass = "50 g"
stiffness = "1e4 N/m"

[[machine.bodies]]
kind = "pendulum"
name = "q"
about = "drum"
mass = "50 g"
length = "30 mm"
suspension = ["50 mm", "0 mm"]
release = { time = "0.1 s" }

[machine.drive]
kind = "dc-series"
voltage = "24 V"
armature_resistance = "1 ohm"
field_resistance = "1 ohm"
field_inductance = "0.05 H"
motor_constant = 1

[machine.load]
kind = "quadratic"
coefficient = "1e-6 N m s^2"

[[machine.schedules]]
parameter = "drive.voltage"
points = [["0 s", "0 V"], ["1 s", "24 V"]]

[machine.tracks.ring]
contact_frequency = "4000 rad/s"

[study]
kind = "run-up"
until = "0.02 s"
start = { p1 = "0.3 rad", p2 = "2 rad", s1 = { displacement = "1 mm" } }
"""
GOOD = "speed (rpm), torque [N m]\n0, 5\n1000, 4\n2000, -1\n"


@pytest.fixture
def machines(here: Path) -> Path:
    (here / "motor.csv").write_text(GOOD)
    (here / "screen.toml").write_text(SCREEN)
    (here / "ring.toml").write_text(RING)
    return here


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("name", ["screen", pytest.param("ring", marks=pytest.mark.slow)])
def test_what_is_spoilt_below_is_good(wucht: Command, machines: Path, name: str) -> None:
    outcome = wucht("run", f"{name}.toml", "-o", "out", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.document["summary"]["energy_residual"] < 1e-9


C, M1, E1, E2, D = (
    "machine.carrier",
    "machine.carrier.mounts[0]",
    "machine.bodies[0] (e1)",
    "machine.bodies[1] (e2)",
    "machine.drives[0]",
)
SET_SCREEN = {
    "carrier.mounts.1.stiffness.x=1 kg": (f"{M1}.stiffness", "this one is a mass"),
    "carrier.mounts.1.stiffness.z=1": ("stiffness.z", "did you mean 'stiffness'?"),
    "carrier.mounts.1.stifness.x=1": ("stifness", "did you mean 'stiffness'?"),
    "carrier.mounts.1.stiffness=[1, 2, 3]": (f"{M1}.stiffness", "given [1, 2, 3]", "a pair [x, y]"),
    "carrier.mounts.1.stiffness=[-1, 1]": (f"{C}.mounts", "at least 0"),
    "carrier.mounts.1.at=[1]": (f"{M1}.at", "given [1]", "pair [x, y]"),
    "carrier.mounts.3.stiffness.x=1": ("mounts.3", "did you mean 'mounts'?"),
    "carrier.mounts.0.stiffness.x=1": ("mounts.0", "did you mean 'mounts'?"),
    "carrier.mounts=3": (f"{C}.mounts", "given 3", "list of mounts"),
    "carrier.mounts=[3]": (f"{C}.mounts", "given [3]", "table"),
    "carrier.mounts=[]": (f"{C}.stiffness", "missing", "mounts"),
    "carrier.stiffness=1": (f"{C}.mounts", "either mounts, or stiffness"),
    "carrier.inertia=0": (f"{C}.inertia", "greater than 0 kg m^2"),
    "carrier.foundation=1": (f"{C}.foundation", "unknown key"),
    "e1.position.x=1 kg": (f"{E1}.position", "this one is a mass"),
    "e1.position=0.1 m": (f"{E1}.position", "given '0.1 m'", "a pair [x, y]"),
    "e1.couple_unbalance=1": (f"{E1}.eccentricity", "either eccentricity or unbalance"),
    "e2.release.time=1 s": (f"{E2}.release", "must be either"),
    "e2.release.speed=-1": (f"{E2}.release.speed", "greater than 0 rad/s"),
    "e2.release=3": (f"{E2}.release", "given 3", "table"),
    "e2.locked=0": (f"{E2}.locked", "unknown key"),
    "drives.e1.pole_pairs=0": (f"{D}.pole_pairs", "at least 1"),
    "drives.e1.pole_pairs=1.5": (f"{D}.pole_pairs", "whole number"),
    "drives.e1.frequency=-50": (f"{D}.frequency", "greater than 0 Hz"),
    "drives.e1.rotor_resistance=0": (f"{D}.rotor_resistance", "greater than 0 ohm"),
    "drives.e1.voltage=3 A": (f"{D}.voltage", "this one is a current"),
    "drives.e1.sense=2": (f"{D}.sense", "1 or -1"),
    "drives.e1.stator=rotor": (f"{D}.stator", "'foundation' or 'carrier'"),
    "drives.e3.voltage=3": ("drives.e3", "did you mean 'drives.e"),
    "loads.e1.viscous.coefficient=-1": ("machine.loads[0].coefficient", "at least 0"),
    "loads.e1.viscous.coeficient=1": ("machine.loads[0].coeficient", "did you mean 'coefficient'?"),
    "loads.e1.coefficient=1": ("loads.e1.coefficient", "loads.e1.viscous"),
    "loads.e1.coulomb.transition_speed=0": ("machine.loads[1].transition_speed", "greater than 0"),
    "study.start.e2.speed=3": ("study.start.e2.speed", "locked until its release"),
    "study.start.carrier.r=1 mm": ("study.start.carrier.r", "this one is a length"),
    "study.over=psi": ("study.over", "no body turns about the rotor"),
}  # fmt: skip
P1, Q = "machine.bodies[1] (p1)", "machine.bodies[4] (q)"
SET_RING = {
    "tracks.ring.contact_frequency=0": ("machine.tracks.ring.contact_frequency", "greater than 0"),
    "tracks.ring.contact_frequency=1 kg": ("machine.tracks.ring.contact_frequency", "this one is a mass"),
    "tracks.ring.contact_frequenci=1": ("machine.tracks.ring", "did you mean 'contact_frequency'?"),
    "tracks.rong.contact_frequency=1": ("tracks.rong", "did you mean 'tracks.ring'?"),
    "p1.restitution=0": (f"{P1}.restitution", "between 0.01 and 1"),
    "p1.restitution=2": (f"{P1}.restitution", "between 0.01 and 1"),
    "p1.diameter=0.3 m": (f"{P1}.diameter", "less than twice the radius"),
    "p1.length=0.05 m": (".track", "given 'ring'", "0.05 m"),
    "p1.suspension=[0.1, 0]": (f"{P1}.suspension", "not allowed on a track"),
    "q.diameter=0.01": (f"{Q}.diameter", "only with track"),
    "q.suspension=0": (f"{Q}.suspension", "a pair [x, y]"),
    "q.release.time=1 kg": (f"{Q}.release.time", "this one is a mass"),
    "q.release.time=0": (f"{Q}.release.time", "greater than 0 s"),
    "p1.about=s1": (f"{P1}.about", "given 's1'", "slides in a guide"),
    "p1.about=q": (f"{P1}.about", "given 'q'", "suspension"),
    "s1.stiffness=0": ("(s1).stiffness", "greater than 0 N/m"),
    "drum.position=[0, 0]": ("(drum).position", "allowed only on a carrier 'xyr'"),
    "carrier.foundation.mass=0": (f"{C}.foundation.mass", "greater than 0 kg"),
    "carrier.foundation.direction=x": (f"{C}.foundation", "free directions: y"),
    "carrier.foundation=3": (f"{C}.foundation", "given 3", "table"),
    "carrier.motion.amplitude=3 kg": (f"{C}.motion", "this one is a mass"),
    "carrier.motion.frequency=0": (f"{C}.motion.frequency", "greater than 0 rad/s"),
    "carrier.motion.direction=z": (f"{C}.motion.direction", "'x', 'y' or 'r'"),
    "carrier.motion.direction=r": (f"{C}.motion", "rad"),
    "carrier.motion.phase=3": (f"{C}.motion.phase", "unknown key"),
    "carrier.motion.points=[[0, 0], [1, 1]]": (f"{C}.motion", "must be"),
    "carrier.directions=fixed": (f"{C}.motion", "direction of the carrier"),
    "drive.field_inductance=0": ("machine.drive.field_inductance", "greater than 0 H"),
    "drive.kind=table": ("machine.drive.", "unknown key"),
    "load.coefficient=-1": ("machine.load.coefficient", "at least 0"),
    "load.kind=viscous": ("machine.load.coefficient", "N m s"),
    "study.start.s1.displacement=1 kg": ("study.start.s1.displacement", "this one is a mass"),
    "study.start.s1.angle=1": ("study.start.s1.angle", "known: displacement, velocity"),
    "study.start.carrier.x=1 mm": ("study.start.carrier.x", "unknown key"),
    "study.start.p1=2 rad": ("study.start.p", "overlap"),
    "study.starts=[{}]": ("study.starts", "either start or starts"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("file", "setting", "says"),
    [("screen.toml", s, says) for s, says in SET_SCREEN.items()] + [("ring.toml", s, says) for s, says in SET_RING.items()],
    ids=[*SET_SCREEN, *SET_RING],
)
def test_a_part_that_cannot_be(refused: Refused, machines: Path, file: str, setting: str, says: tuple[str, ...]) -> None:
    message = refused("run", file, "-o", "out", "--json", "--set", setting, says=(f"{file}: ", *says))
    assert "nput should" not in message
    assert not Path("out").exists()


NESTED = {
    "screen": (
        "carrier.mounts.1.stiffness.x=3e4 N/m", "carrier.mounts.2.at=[0.6, 0]", "e1.position.y=0.1 m",
        "e2.release.speed=20 rad/s",
        "loads.e1.coulomb.torque=0.1 N m", "drives.e1.voltage=400 V", "study.start.e1.speed=60 rad/s",
    ),
    "ring": (
        "carrier.motion.amplitude=2 mm", "carrier.foundation.mass=60 kg", "tracks.ring.contact_frequency=3000 rad/s",
        "q.release.time=0.01 s", "q.suspension.y=1 mm", "carrier.stiffness.y=1e5", "load.coefficient=0",
        "study.start.s1.velocity=1",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", NESTED)
def test_nested_settings_arrive(machines: Path, name: str) -> None:
    from wucht.cli.options import parse_settings
    from wucht.studies.study_file import read_study

    settings = parse_settings([s for s in NESTED[name] if not s.startswith("study")])
    values = read_study(f"{name}.toml", settings).subject.values
    for path, value in settings.items():
        paths = [f"{path}.x", f"{path}.y"] if isinstance(value, list) else [path]
        assert set(paths) <= set(values)
    expected = {"screen": {"carrier.mounts.1.stiffness.x": 3e4, "carrier.mounts.2.at.x": 0.6, "e2.release.speed": 20.0},
                "ring": {"carrier.motion.amplitude": 0.002,
                         "tracks.ring.contact_frequency": 3000.0, "carrier.stiffness.y": 1e5}}[name]  # fmt: skip
    assert {k: values[k] for k in expected} == pytest.approx(expected)


@pytest.mark.parametrize(
    ("release", "says"), [("{ speed = 1 }", "no other body's speed"), ("{ time = 0 }", "greater than 0 s")]
)
def test_a_rotor_that_nothing_releases(refused: Refused, machines: Path, release: str, says: str) -> None:
    Path("s.toml").write_text(RING.replace('name = "drum"', f'name = "drum"\nrelease = {release}'))
    refused("run", "s.toml", says=("s.toml: machine.bodies[0] (drum).release", says))


# Schedules

SCHEDULES = {
    "unknown parameter": ('"drives.e1.voltag"', None, None, "parameter", "did you mean 'drives.e1.voltage'?"),
    "no parameter": ("3", None, None, "parameter", "given 3"),
    "a name": ('"e1.name"', None, None, "parameter", "must be a parameter"),
    "locked": ('"e2.locked"', '[["0 s", 1], ["1 s", 0]]', None, "parameter", "at one moment"),
    "release": ('"e2.release.speed"', '[["0 s", 50], ["1 s", 0]]', None, "parameter", "at one moment"),
    "no points": (None, "[]", None, "points", "given []"),
    "no pairs": (None, "[1, 2]", None, "points", "list of pairs"),
    "times back": (None, "[[1, 0], [0, 1]]", None, "points", "times increase"),
    "one time twice": (None, "[[1, 0], [1, 1]]", None, "points", "times increase"),
    "a time in kg": (None, '[["0 kg", 0], [1, 1]]', None, "points[0][0]", "this one is a mass"),
    "a value in m": (None, '[[0, "1 m"], [1, 1]]', None, "points[0][1]", "this one is a length"),
    "interpolation": (None, None, '"cubic"', "interpolation", "known: linear, smooth, steps"),
}  # fmt: skip


@pytest.mark.parametrize("case", SCHEDULES.values(), ids=SCHEDULES.keys())
def test_a_wrong_schedule(refused: Refused, machines: Path, case: tuple[Any, ...]) -> None:
    parameter, points, interpolation, key, says = case
    text = SCREEN
    if parameter:
        text = text.replace('parameter = "drives.e1.voltage"', f"parameter = {parameter}")
    if points:
        text = text.replace('[["0 s", "0 V"], ["1 s", "230 V"]]', points)
    if interpolation:
        text = text.replace('"230 V"]]', f'"230 V"]]\ninterpolation = {interpolation}')
    Path("s.toml").write_text(text)
    refused("run", "s.toml", "--json", says=(f"s.toml: machine.schedules[0].{key}: ", says))


def test_a_schedule_of_what_counts_at_the_start_only(refused: Refused, machines: Path) -> None:
    drive = 'kind = "constant-speed"\nspeed = 50\n'
    text = RING.replace(RING[RING.index('kind = "dc-series"') : RING.index("[machine.load]")], drive)
    Path("s.toml").write_text(text.replace('parameter = "drive.voltage"', 'parameter = "drive.angle"').replace(" V", " rad"))
    refused("run", "s.toml", says=("s.toml: machine.schedules[0].parameter", "given 'drive.angle'", "at one moment"))
    text = text.replace('parameter = "drive.voltage"', 'parameter = "drive.speed"\ninterpolation = "steps"')
    Path("s.toml").write_text(text.replace(" V", " rad/s"))
    refused("run", "s.toml", says=("s.toml: machine.schedules[0].interpolation", "cannot jump"))


def test_two_schedules_of_one_parameter(refused: Refused, machines: Path) -> None:
    again = SCREEN[SCREEN.index("[[machine.schedules]]") : SCREEN.index("[study]")]
    Path("s.toml").write_text(SCREEN.replace("[study]", f"{again}[study]"))
    refused("run", "s.toml", says=("machine.schedules[1].parameter", "has a schedule already"))


# Tables

TABLES = {
    "empty": ("", "at least two rows", "there are 0"),
    "comments": ("# nothing\n\n", "there are 0"),
    "a heading": ("speed, torque\n", "there are 0"),
    "one row": ("0, 1\n", "there are 1"),
    "text": ("0,1\n1,abc\n", "line 2", "'abc' is not a finite number"),
    "NaN": ("0,1\n1,nan\n", "line 2", "'nan'"),
    "too large": ("0,1\n1,1e400\n", "line 2", "'1e400'"),
    "beyond all numbers": ("0,1e308\n1,-1e308\n", "line 1", "a torque of at most 1e+30 N m"),
    "beyond all numbers in its unit": ("speed [rpm],torque [MN m]\n0,1\n1,1e303\n", "line 3", "a finite torque"),
    "unit of another kind": ("speed [kg], torque [N m]\n0,1\n1,2\n", "line 1", "this one is a mass"),
    "unknown unit": ("speed [foo], torque [N m]\n0,1\n1,2\n", "line 1", "'foo' is not a known unit"),
    "no unit between brackets": ("speed [], torque [N m]\n0,1\n1,2\n", "line 1"),
    "turns or radians a second": ("speed [1/s], torque [N m]\n0,1\n1,2\n", "line 1", "rad/s"),
    "exchanged": ("torque, speed\n0,1\n1,2\n", "line 1", "exchanged"),
    "equal speeds": ("0,1\n1,2\n1,3\n", "line 3", "does not increase"),
    "falling speeds": ("2,1\n1,2\n", "line 2", "does not increase"),
    "decimal commas between commas": ("0,1,5\n100,1,2\n", "line 1", "3 columns"),
    "two commas in a number between tabs": ("0\t1,500,0\n100\t1,2\n", "line 1", "not a finite number"),
    "one column": ("1\n2\n", "line 1", "1 columns"),
    "units below the heading": ("speed,torque\nrpm,N m\n0,1\n1,2\n", "line 2", "'rpm' is not a finite number"),
    "hexadecimal": ("0x1,1\n2,2\n", "line 1"),
    "underscore": ("0,1_0\n1,2\n", "line 1"),
}  # fmt: skip


@pytest.mark.parametrize("case", TABLES.values(), ids=TABLES.keys())
def test_a_wrong_table(refused: Refused, machines: Path, case: tuple[str, ...]) -> None:
    content, *says = case
    Path("motor.csv").write_text(content)
    refused("run", "screen.toml", "--json", says=("screen.toml: machine.drives[1].file: given 'motor.csv'; ", *says))


FILES = {
    "not there": ("'other.csv'", "there is no such file: other.csv"),
    "a folder": ("'folder'", "cannot be read"),
    "no text": ("'binary.csv'", "UTF-8"),
    "empty": ("''", "name of a file"),
    "a number": ("3", "name of a file"),
    "both": ("'motor.csv'\npoints = [[0, 1], [1, 2]]", "either file or points"),
}  # fmt: skip


@pytest.mark.parametrize(("name", "says"), FILES.values(), ids=FILES.keys())
def test_a_table_that_cannot_be_read(refused: Refused, machines: Path, name: str, says: str) -> None:
    Path("folder").mkdir()
    Path("binary.csv").write_bytes(bytes(range(256)))
    Path("s.toml").write_text(SCREEN.replace('file = "motor.csv"', f"file = {name}"))
    refused("run", "s.toml", "--json", says=("s.toml: machine.drives[1].file", says))


SAME = {
    "with a byte order mark": "\ufeff" + GOOD,
    "with Windows line ends": GOOD.replace("\n", "\r\n"),
    "with semicolons and decimal commas": "Drehzahl (rpm); Moment (N m)\n0;5,0\n1000;4,0\n2000;-1,0\n",
    "with tabs": "rpm\tN m\n0\t5\n1000\t4\n2000\t-1\n",
    "with quotes": '"speed [rpm]","torque [N m]"\n"0","5"\n"1000","4"\n"2000","-1"\n',
    "with units alone": "rpm, N m\n0,5\n1000,4\n2000,-1\n",
}  # fmt: skip


@pytest.mark.parametrize("content", SAME.values(), ids=SAME.keys())
def test_the_same_table_in_another_dress(machines: Path, content: str) -> None:
    from wucht.files.tables import SPEED_TORQUE, read_table

    expected = np.array(read_table(Path("motor.csv"), SPEED_TORQUE))
    Path("other.csv").write_bytes(content.encode())
    assert np.array(read_table(Path("other.csv"), SPEED_TORQUE)) == pytest.approx(expected)


def test_the_only_load_may_be_a_table_too(machines: Path) -> None:
    from wucht.machines.parts.table_load import TableLoad
    from wucht.studies.study_file import read_study

    Path("s.toml").write_text(
        RING.replace('kind = "quadratic"\ncoefficient = "1e-6 N m s^2"', 'kind = "table"\nfile = "motor.csv"')
    )
    load = read_study("s.toml").subject.parts[-1]
    assert isinstance(load, TableLoad)
    assert load.torque_at(0.0) == pytest.approx(0.0)
    assert load.torque_at(1000 * 2 * 3.141592653589793 / 60) == pytest.approx(4.0)


@pytest.mark.parametrize("bodies", ["3", "'x'", "true", "{ a = 1 }"])
def test_bodies_that_are_none_beside_a_setting(refused: Refused, here: Path, bodies: str) -> None:
    Path("s.toml").write_text(f"[machine]\nbodies = {bodies}\nset = {{ carrier.mass = 1 }}\ncarrier = {{ stiffness = 1 }}\n")
    refused("run", "s.toml", says=("s.toml: machine.bodies", "[[machine.bodies]]"))
