"""What can be wrong with carriers, bodies, drives, loads, tables, schedules and tracks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.refusals import cases_of, check_file, check_refusal

from wucht import run_file
from wucht.cli.options import parse_settings

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


SET_SCREEN = [
    "carrier.mounts.1.stiffness.x=1 kg", "carrier.mounts.1.stiffness.z=1", "carrier.mounts.1.stifness.x=1",
    "carrier.mounts.1.stiffness=[1, 2, 3]", "carrier.mounts.1.stiffness=[-1, 1]", "carrier.mounts.1.at=[1]",
    "carrier.mounts.3.stiffness.x=1", "carrier.mounts=[3]", "carrier.mounts=[]", "carrier.stiffness=1", "carrier.inertia=0",
    "carrier.foundation=1", "e1.position=0.1 m", "e1.couple_unbalance=1", "e2.release.time=1 s", "e2.release.speed=-1",
    "drives.e1.pole_pairs=1.5", "drives.e1.voltage=3 A", "drives.e1.sense=2", "drives.e1.stator=rotor", "drives.e3.voltage=3",
    "loads.e1.viscous.coefficient=-1", "loads.e1.coefficient=1", "loads.e1.coulomb.transition_speed=0",
    "study.start.e2.speed=3", "study.start.carrier.r=1 mm", "study.over=psi",
]  # fmt: skip
SET_RING = [
    "tracks.ring.contact_frequency=0", "tracks.ring.contact_frequenci=1", "tracks.rong.contact_frequency=1",
    "p1.restitution=2", "p1.diameter=0.3 m", "p1.length=0.05 m", "p1.suspension=[0.1, 0]", "q.diameter=0.01",
    "q.release.time=0", "p1.about=s1", "p1.about=q", "drum.position=[0, 0]", "carrier.foundation.direction=x",
    "carrier.motion.frequency=0", "carrier.motion.direction=z", "carrier.motion.direction=r",
    "carrier.motion.points=[[0, 0], [1, 1]]", "carrier.directions=fixed", "drive.field_inductance=0", "drive.kind=table",
    "load.kind=viscous", "study.start.s1.displacement=1 kg", "study.start.s1.angle=1", "study.start.carrier.x=1 mm",
    "study.start.p1=2 rad", "study.starts=[{}]",
]  # fmt: skip


@pytest.mark.parametrize(("name", "setting"), [*(("screen", s) for s in SET_SCREEN), *(("ring", s) for s in SET_RING)])
def test_a_part_that_cannot_be(machines: Path, name: str, setting: str) -> None:
    check_file(name, {"screen": SCREEN, "ring": RING}[name], {}, parse_settings([setting]))


# Schedules

PARAMETER, POINTS = 'parameter = "drives.e1.voltage"', '[["0 s", "0 V"], ["1 s", "230 V"]]'
JUMPS = '[["0 s", 1], ["1 s", 0]]'
AGAIN = SCREEN[SCREEN.index("[[machine.schedules]]") : SCREEN.index("[study]")]
SCREEN_CHANGES = {
    PARAMETER: ['parameter = "drives.e1.voltag"', "parameter = 3", 'parameter = "e1.name"'],
    POINTS: [
        "[]", "[1, 2]", "[[1, 0], [1, 1]]", '[["0 kg", 0], [1, 1]]', '[[0, "1 m"], [1, 1]]',
        f'{POINTS}\ninterpolation = "cubic"',
    ],
    "[study]": [f"{AGAIN}[study]"],
    'file = "motor.csv"': [
        f"file = {name}"
        for name in (
            "'other.csv'", "'folder'", "'binary.csv'", "'motor.csv'\npoints = [[0, 1], [1, 2]]",
        )
    ],
}  # fmt: skip


@pytest.mark.parametrize(("old", "new"), cases_of(SCREEN_CHANGES))
def test_a_wrong_schedule_or_table(machines: Path, old: str, new: str) -> None:
    Path("folder").mkdir()
    Path("binary.csv").write_bytes(bytes(range(256)))
    check_file("screen", SCREEN, {old: new})


@pytest.mark.parametrize("parameter", ["e2.locked", "e2.release.speed"])
def test_what_happens_at_one_moment_has_no_schedule(machines: Path, parameter: str) -> None:
    check_file("screen", SCREEN, {PARAMETER: f'parameter = "{parameter}"', POINTS: JUMPS})


def test_a_schedule_of_what_counts_at_the_start_only(machines: Path) -> None:
    text = RING.replace(
        RING[RING.index('kind = "dc-series"') : RING.index("[machine.load]")], 'kind = "constant-speed"\nspeed = 50\n'
    )
    held = 'parameter = "drive.voltage"'
    check_file("ring", text.replace(" V", " rad"), {held: 'parameter = "drive.angle"'})
    check_file("ring", text.replace(" V", " rad/s"), {held: 'parameter = "drive.speed"\ninterpolation = "steps"'})


# Tables

TABLES = [
    "# nothing\n\n", "speed, torque\n", "0, 1\n", "0,1\n1,abc\n", "0,1\n1,1e400\n", "0,1e308\n1,-1e308\n",
    "speed [kg], torque [N m]\n0,1\n1,2\n", "speed [foo], torque [N m]\n0,1\n1,2\n", "torque, speed\n0,1\n1,2\n",
    "0,1\n1,2\n1,3\n", "0,1,5\n100,1,2\n", "0\t1,500,0\n100\t1,2\n", "1\n2\n", "speed,torque\nrpm,N m\n0,1\n1,2\n",
    "0,1_0\n1,2\n",
]  # fmt: skip


@pytest.mark.parametrize("content", TABLES)
def test_a_wrong_table(machines: Path, content: str) -> None:
    Path("motor.csv").write_text(content)
    check_refusal(f"motor.csv: {content}", lambda: run_file("screen.toml", folder="out"))
    assert not Path("out").exists()


SAME = {
    "with Windows line ends": GOOD.replace("\n", "\r\n"),
    "with semicolons and decimal commas": "Drehzahl (rpm); Moment (N m)\n0;5,0\n1000;4,0\n2000;-1,0\n",
    "with quotes": '"speed [rpm]","torque [N m]"\n"0","5"\n"1000","4"\n"2000","-1"\n',
}


@pytest.mark.parametrize("content", SAME.values(), ids=SAME.keys())
def test_the_same_table_in_another_dress(machines: Path, content: str) -> None:
    from wucht.files.tables import SPEED_TORQUE, read_table

    expected = np.array(read_table(Path("motor.csv"), SPEED_TORQUE))
    Path("other.csv").write_bytes(content.encode())
    assert np.array(read_table(Path("other.csv"), SPEED_TORQUE)) == pytest.approx(expected)
