"""Machines from part objects: the same as from a file, refused with the same sentences, and shown."""

from __future__ import annotations

import doctest
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import refused, rejected

import wucht
from wucht import kinds, parts
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.catalogue import described_machine, load_document
from wucht.machines import machine as machine_module
from wucht.machines.models import DimensionlessMachine
from wucht.machines.parts.base import Body, Drive, Load, Part
from wucht.machines.parts.support import Support

CARRIER: dict[str, Any] = {"mass": "1 kg", "stiffness": "1e5 N/m", "damping": "200 N s/m"}
DRUM: dict[str, Any] = {"name": "drum", "mass": "9 kg", "eccentricity": "1 mm", "inertia": "0.03 kg m^2"}
P1: dict[str, Any] = {"name": "p1", "about": "drum", "mass": "125 g", "length": "104 mm", "damping": "0.17 N m s"}
MOTOR: dict[str, Any] = {"slope": "0.04 N m s", "no_load_speed": "200 rad/s"}


def same(first: wucht.Machine, second: wucht.Machine) -> bool:
    """Whether two machines have equal systems, numbers and warnings."""
    assert isinstance(first, wucht.Machine)
    assert isinstance(second, wucht.Machine)
    assert first.system == second.system
    assert dict(first.parameters) == dict(second.parameters)
    assert (first.warnings, first.schedules, first.tracks) == (second.warnings, second.schedules, second.tracks)
    assert (first.start_angles, first.start_positions) == (second.start_angles, second.start_positions)
    return first.title == second.title


# As somebody writes it in Python, beside the file.


def test_a_drum_with_a_ring_of_balls() -> None:
    ball = {"about": "drum", "mass": "0.1 kg", "length": "0.1 m", "track": "ring", "diameter": "20 mm"}
    points = [["0 s", 0], ["5 s", "0.04 N m s"]]
    in_python = wucht.Machine(
        parts.Carrier(**CARRIER, foundation={"direction": "y", "mass": 50, "stiffness": "1e6 N/m"}),
        [parts.Rotor(**DRUM), *(parts.Pendulum(name=f"b{i}", **ball) for i in range(3))],
        drives=[parts.LinearDrive(**MOTOR)],
        loads=[parts.ViscousLoad(coefficient=0.01), parts.CoulombLoad(torque="0.05 N m")],
        schedules=[{"parameter": "drive.slope", "points": points, "interpolation": "smooth"}],
        tracks={"ring": {"contact_frequency": "4000 rad/s"}},
        title="A drum",
    )
    in_file = machine_from({
        "title": "A drum",
        "carrier": {**CARRIER, "foundation": {"direction": "y", "mass": 50, "stiffness": "1e6 N/m"}},
        "bodies": [{"kind": "rotor", **DRUM}, *({"kind": "pendulum", "name": f"b{i}", **ball} for i in range(3))],
        "drive": {"kind": "linear", **MOTOR},
        "loads": [{"kind": "viscous", "coefficient": 0.01}, {"kind": "coulomb", "torque": "0.05 N m"}],
        "schedules": [{"parameter": "drive.slope", "points": points, "interpolation": "smooth"}],
        "tracks": {"ring": {"contact_frequency": "4000 rad/s"}},
    })  # fmt: skip
    assert same(in_python, in_file)


def test_a_screen_with_two_exciters() -> None:
    mounts = [{"at": [x, 0], "stiffness": [2e4, 4e4], "damping": [100, 200]} for x in (-0.5, 0.5)]
    exciter = {"mass": "5 kg", "unbalance": "0.1 kg m", "inertia": "0.02 kg m^2"}
    release = {"speed": "50 rad/s"}
    in_python = wucht.Machine(
        parts.PlanarCarrier(mass=100, inertia=20, mounts=[parts.Mount(**m) for m in mounts]),
        [
            parts.Rotor(name="e1", position=("-0.3 m", "0.2 m"), **exciter),
            parts.Rotor(name="e2", position=(0.3, 0.2), release=parts.Release(**release), **exciter),
        ],
        [
            parts.ConstantSpeed(on="e1", speed="100 rad/s"),
            parts.TableDrive(on="e2", points=[(0, 5), (100, -1)], stator="carrier"),
        ],
    )
    in_file = machine_from({
        "carrier": {"directions": "xyr", "mass": 100, "inertia": 20, "mounts": mounts},
        "bodies": [
            {"kind": "rotor", "name": "e1", "position": [-0.3, 0.2], **exciter},
            {"kind": "rotor", "name": "e2", "position": [0.3, 0.2], "release": release, **exciter},
        ],
        "drives": [
            {"kind": "constant-speed", "on": "e1", "speed": 100},
            {"kind": "table", "on": "e2", "points": [[0, 5], [100, -1]], "stator": "carrier"},
        ],
    })  # fmt: skip
    assert same(in_python, in_file)


def test_a_dimensionless_model() -> None:
    numbers = {"epsilon": 0.1, "sigma": 0.05, "lambda": 3.0, "u": 2.5}
    schedules = [{"parameter": "u", "points": [[0, 2.5], [100, 1]]}]
    in_python = wucht.Machine(parts.LavalRotor(**numbers), schedules=schedules)
    assert same(in_python, machine_from({"model": "laval-rotor", "parameters": numbers, "schedules": schedules}))
    assert in_python.dimensionless


# Every carrier, track, schedule, load, release and model of the catalogue.


def again(name: str) -> tuple[wucht.Machine, wucht.Machine]:
    """A machine of the catalogue, and the same from its parts, each built anew in Python."""
    document, path = load_document(name)
    described = described_machine(document, path, name, {})
    machine = machine_from(described)
    made = [type(p)(**p.model_dump(by_alias=True, exclude_none=True)) for p in machine.parts]
    families: list[list[Part]] = [[p for p in made if isinstance(p, f)] for f in (Body, Drive, Load)]
    rest = {k: described[k] for k in ("schedules", "tracks") if k in described}
    first = next(p for p in made if isinstance(p, Support | DimensionlessMachine))
    return machine, wucht.Machine(first, *families, title=machine.title, **rest)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "name",
    [
        "drozdetskaya-2020/table-3.1-carrier", "drozdetskaya-2020/table-3.1-laval", "drozdetskaya-2020/table-5.1",
        "drozdetskaya-2020/table-a.1", "drozdetskaya-2020/r1", "drozdetskaya-2020/figure-5.1", "practice/grinder-4-balls",
        "practice/angle-grinder", "practice/laundry-drum-tumbling", "practice/laboratory-centrifuge", "practice/screen",
        "practice/balls-at-resonance-thick-oil", "sperling-rollers/figure-7", "sperling-rollers/table-3",
        "sperling-vibration/figure-2a", "sperling-vibration/figure-4", "sperling-vibration/figure-7",
        "sperling-vibration/sustained-rotation", "sperling-vibration/self-synchronisation-soft",
    ],
)  # fmt: skip
def test_a_machine_of_the_catalogue_from_its_parts(name: str) -> None:
    assert same(*again(name))


# What is wrong is the same sentence; the place is the part's path, or its table.

Refused = tuple[Callable[[], object], dict[str, Any], str]


def file(**changes: Any) -> dict[str, Any]:
    """The table of the machine below, changed."""
    bodies = [{"kind": "rotor", **DRUM}, {"kind": "pendulum", **P1}]
    return {"carrier": CARRIER, "bodies": bodies, "drive": {"kind": "linear", **MOTOR}} | changes


def made(*bodies: Any, carrier: Any = None, drives: Any = None, **others: Any) -> wucht.Machine:
    """A machine in Python, with two bodies if none is given."""
    drives = [parts.LinearDrive(**MOTOR)] if drives is None else drives
    every_body = list(bodies) or [parts.Rotor(**DRUM), parts.Pendulum(**P1)]
    return wucht.Machine(carrier or parts.Carrier(**CARRIER), every_body, drives, **others)


ROTOR2 = DRUM | {"name": "two"}
LINEAR = {"kind": "linear", **MOTOR}
LAVAL = {"epsilon": 0.1, "sigma": 0.05, "lambda": 3.0, "u": 2.5}


def bodies(*tables: dict[str, Any]) -> dict[str, Any]:
    """The table with these bodies: rotors, and pendulums about something."""
    return file(bodies=[{"kind": "pendulum" if "about" in b else "rotor", **b} for b in tables])


REFUSED: dict[str, Refused] = {
    "inertia": (
        lambda: parts.Pendulum(**P1, inertia=1e-9), bodies(DRUM, P1 | {"inertia": 1e-9}), "pendulum.inertia",
    ),
    "limit": (lambda: parts.Rotor(**DRUM | {"mass": 0}), bodies(DRUM | {"mass": 0}), "rotor.mass"),
    "unit": (lambda: parts.Rotor(**DRUM | {"mass": "1 m"}), bodies(DRUM | {"mass": "1 m"}), "rotor.mass"),
    "missing": (
        lambda: parts.Rotor(name="drum", mass=1, eccentricity=0), bodies({"name": "drum", "mass": 1, "eccentricity": 0}),
        "rotor.inertia",
    ),
    "unknown": (lambda: parts.Rotor(**DRUM, masss=1), bodies(DRUM | {"masss": 1}), "rotor.masss"),
    "spring": (lambda: parts.Carrier(mass=1), file(carrier={"mass": 1}), "carrier.stiffness"),
    "model": (
        lambda: parts.LavalRotor(**LAVAL | {"u": -1}), {"model": "laval-rotor", "parameters": LAVAL | {"u": -1}},
        "laval-rotor.u",
    ),
    "about": (
        lambda: made(parts.Rotor(**DRUM), parts.Pendulum(**P1 | {"about": "drom"})), bodies(DRUM, P1 | {"about": "drom"}),
        "p1.about",
    ),
    "circle": (
        lambda: made(parts.Rotor(**DRUM), parts.Pendulum(**P1 | {"about": "p1"})), bodies(DRUM, P1 | {"about": "p1"}),
        "p1.about",
    ),
    "taken": (lambda: made(parts.Rotor(**DRUM | {"name": "psi"})), bodies(DRUM | {"name": "psi"}), "bodies[0].name"),
    "twice": (lambda: made(parts.Rotor(**DRUM), parts.Rotor(**DRUM)), bodies(DRUM, DRUM), "bodies"),
    "no rotor": (
        lambda: made(*(parts.Pendulum(**P1 | n) for n in ({"about": "b"}, {"name": "b", "about": "p1"}))),
        bodies(P1 | {"about": "b"}, P1 | {"name": "b", "about": "p1"}), "p1.about",
    ),
    "no body": (lambda: wucht.Machine(parts.Carrier(**CARRIER)), file(bodies=[]), "bodies"),
    "position": (
        lambda: made(parts.Rotor(**DRUM, position=[0, 1])), bodies(DRUM | {"position": [0, 1]}), "drum.position",
    ),
    "on": (
        lambda: made(drives=[parts.LinearDrive(on="dram", **MOTOR)]), file(drive=LINEAR | {"on": "dram"}), "drive.on",
    ),
    "on what": (
        lambda: made(parts.Rotor(**DRUM), parts.Rotor(**ROTOR2)), bodies(DRUM, ROTOR2), "drive.on",
    ),
    "on what of several": (
        lambda: made(parts.Rotor(**DRUM), parts.Rotor(**ROTOR2),
                     drives=[parts.LinearDrive(**MOTOR), parts.LinearDrive(on="two", **MOTOR)]),
        {k: v for k, v in bodies(DRUM, ROTOR2).items() if k != "drive"} | {"drives": [LINEAR, LINEAR | {"on": "two"}]},
        "drives[0].on",
    ),
    "two drives": (
        lambda: made(drives=[parts.LinearDrive(**MOTOR)] * 2),
        {k: v for k, v in file(drives=[LINEAR] * 2).items() if k != "drive"}, "drives",
    ),
    "two loads": (
        lambda: made(loads=[parts.ViscousLoad(coefficient=1)] * 2),
        file(loads=[{"kind": "viscous", "coefficient": 1}] * 2), "loads",
    ),
    "release": (
        lambda: made(parts.Rotor(**DRUM, release={"speed": 3})), bodies(DRUM | {"release": {"speed": 3}}), "drum.release",
    ),
    "tracks": (lambda: made(tracks={"ring": {}}), file(tracks={"ring": {}}), "tracks.ring"),
    "no table": (lambda: made(tracks=3), file(tracks=3), "tracks"),
    "schedules": (
        lambda: made(schedules=[{"parameter": "drive.slop"}]), file(schedules=[{"parameter": "drive.slop"}]),
        "schedules[0].parameter",
    ),
    "scheduled": (
        lambda: made(schedules=[{"parameter": "drum.mass", "points": [[0, -1]]}]),
        file(schedules=[{"parameter": "drum.mass", "points": [[0, -1]]}]), "schedules[0].points (t = 0)",
    ),
    "beside a model": (
        lambda: wucht.Machine(parts.LavalRotor(**LAVAL), [parts.Rotor(**DRUM)]),
        {"model": "laval-rotor", "parameters": LAVAL, "bodies": [DRUM]}, "bodies",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("in_python", "in_file", "place"), REFUSED.values(), ids=REFUSED.keys())
def test_a_refusal_is_the_same_sentence(in_python: Callable[[], object], in_file: dict[str, Any], place: str) -> None:
    with pytest.raises(InputError) as of_python:
        in_python()
    with pytest.raises(InputError) as of_file:
        machine_from(in_file)
    assert of_python.value.explanation == of_file.value.explanation
    assert of_python.value.value == of_file.value.value
    assert of_python.value.location == place
    assert of_file.value.location.startswith("machine.")


@given(mass=st.floats(-1, 1), length=st.floats(-1, 1), inertia=st.floats(-1, 1))
@settings(max_examples=50, deadline=None)
def test_a_part_is_the_same_or_refused_alike(mass: float, length: float, inertia: float) -> None:
    numbers = P1 | {"mass": mass, "length": length, "inertia": inertia}
    outcomes = []
    for build in (lambda: made(parts.Rotor(**DRUM), parts.Pendulum(**numbers)), lambda: machine_from(bodies(DRUM, numbers))):
        try:
            outcomes.append(build().values)
        except InputError as error:
            outcomes.append((error.location.rpartition(".")[2], error.value, error.explanation))
    assert outcomes[0] == outcomes[1]


@pytest.mark.parametrize(
    ("given", "where"),
    [
        (lambda: wucht.Machine(parts.Rotor(**DRUM)), "carrier"),
        (lambda: made(parts.LinearDrive(**MOTOR)), "bodies[0]"),
        (lambda: made(drives=parts.LinearDrive(**MOTOR)), "drives"),
        (lambda: made(drives=[{"kind": "linear", **MOTOR}]), "drives[0]"),
        (lambda: made(loads=[parts.LinearDrive(**MOTOR)]), "loads[0]"),
    ],
)
def test_what_is_no_part_of_that_kind_is_refused(given: Callable[[], object], where: str) -> None:
    with pytest.raises(InputError) as error:
        given()
    assert error.value.location == where


# The machine itself.


def test_a_changed_machine_derives_anew_and_keeps_the_first() -> None:
    machine = made()
    before = machine.values
    bare = machine.with_fields(parameters={}, title="bare")
    assert (bare.values, bare.title) == ({}, "bare")
    assert machine.values is before
    with refused("titel", "title", "with_values"):
        machine.with_fields(titel="x")
    with pytest.raises(AttributeError):
        machine.title = "x"  # type: ignore[misc]
    assert same(pickle.loads(pickle.dumps(machine)), machine)


def test_a_part_used_in_one_machine_serves_in_another() -> None:
    several = wucht.Machine(
        parts.PlanarCarrier(mass=100, inertia=20, stiffness=1e4, rotation_stiffness=1e3),
        [parts.Rotor(**DRUM), parts.Rotor(**ROTOR2)],
        [parts.LinearDrive(on=n, **MOTOR) for n in ("drum", "two")],
    )
    assert several.drives[0].path == "drives.drum"
    assert made(drives=[several.drives[0]]).drives[0].path == "drive"


def test_its_example_is_true() -> None:
    assert doctest.testmod(machine_module).failed == 0
    assert doctest.testmod(sys.modules["wucht.machines.parts"]).failed == 0


def test_it_is_shown_in_two_lines_and_as_a_table() -> None:
    machine = made(title="Drum <1>")
    assert repr(machine) == "<Machine 'Drum <1>'\n rotor drum, pendulum p1; drive linear on drum; 13 parameters>"
    html = machine._repr_html_()
    assert "Drum &lt;1&gt;" in html
    assert "<td>p1.length</td><td>0.104 m</td><td>length</td>" in html
    assert repr(wucht.Machine(parts.LavalRotor(**LAVAL))).endswith("rotor; 4 parameters>")


# The names in Python, and where parts come from.


def test_every_part_is_found_by_the_name_of_its_class() -> None:
    assert {"Carrier", "Rotor", "Induction", "TableLoad", "TableDrive", "SelfBalancingRotor", "Mount", "Release"} <= set(
        dir(parts)
    )
    assert parts.Rotor.kind == "rotor"
    with pytest.raises(AttributeError, match="there is no part 'Rotr'; did you mean 'Rotor'"):
        parts.Rotr  # noqa: B018
    assert not hasattr(parts, "rotr")


def test_completion_shows_the_names_of_the_package_and_loads_nothing() -> None:
    code = "import sys, wucht; names = dir(wucht); assert 'numpy' not in sys.modules; print(*names)"
    names = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert {"Machine", "parts", "load_machine", "run", "RunUp"} <= set(names)
    assert set(wucht.__all__) <= set(names)
    with pytest.raises(AttributeError, match="no attribute 'machine_from'"):
        wucht.machine_from  # noqa: B018


ELSEWHERE = """
from typing import ClassVar
from wucht.machines.parts.base import Load, si

class Elsewhere(Load):
    kind: ClassVar[str] = "elsewhere"
    drag: float = si("N m s", "drag", "d", ge=0)

    def torque(self, speed):
        return self.symbol("drag") * speed
"""


@pytest.fixture
def loaded_anew() -> Iterator[None]:
    """Entry points are read once: for these tests again, before and after."""
    kinds._load.cache_clear()
    yield
    kinds._load.cache_clear()


@pytest.mark.usefixtures("loaded_anew")
def test_parts_of_another_package_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "elsewhere_parts"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "elsewhere.py").write_text(ELSEWHERE)
    monkeypatch.syspath_prepend(tmp_path)
    asked = []
    entry = EntryPoint("elsewhere", "elsewhere_parts", parts.GROUP)
    monkeypatch.setattr(kinds, "entry_points", lambda group: asked.append(group) or [entry])
    load = parts.loads()["elsewhere"]
    try:
        assert load.__module__ == "elsewhere_parts.elsewhere"
        assert parts.Elsewhere is load
        assert asked == ["wucht.parts"]  # once
        machine = made(loads=[parts.Elsewhere(drag=0.1)])
        assert same(machine, machine_from(file(load={"kind": "elsewhere", "drag": 0.1})))
    finally:
        load.kind = ""  # other tests list the kinds of the package


@pytest.mark.usefixtures("loaded_anew")
def test_a_package_that_cannot_be_loaded_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("broken", "no_such_parts", parts.GROUP)
    monkeypatch.setattr(kinds, "entry_points", lambda group: [entry])
    with rejected("not-loaded", "'broken'", "no_such_parts", "No module named"):
        parts.loads()


def test_the_parts_of_the_package_are_entries_like_any_other() -> None:
    from importlib.metadata import entry_points

    assert {"wucht.machines.parts", "wucht.machines.models"} <= {e.value for e in entry_points(group=parts.GROUP)}
