"""The table of a machine from its parts: the same machine is read back, whatever it was built from."""

from __future__ import annotations

import pytest

from wucht import Machine, load_machine, parts
from wucht.errors import WuchtError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_document, names
from wucht.files.documents import document_of, refuse_bare_frequencies
from wucht.files.machine_tables import machine_table
from wucht.files.toml_text import toml_text

MACHINES = [name for name in names() if "machine" in load_document(name)[0]]


def read_back(machine: Machine, tmp_path: object) -> Machine:
    text = toml_text({"machine": machine_table(machine)})
    document = document_of(text, tmp_path)  # type: ignore[arg-type]
    refuse_bare_frequencies(document["machine"], "machine")
    return machine_from(document["machine"])


@pytest.mark.parametrize("name", MACHINES)
def test_every_machine_of_the_catalogue_is_read_back(name: str, tmp_path: object) -> None:
    machine = load_machine(name)
    copy = read_back(machine, tmp_path)
    assert copy.values == machine.values
    assert copy.system == machine.system
    assert copy.start_angles == machine.start_angles


def drum(**options: object) -> Machine:
    rotor = parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2")
    motor = parts.LinearDrive(slope="0.04 N m s", no_load_speed="200 rad/s")
    return Machine(parts.Carrier(mass="1 kg", stiffness="1e5 N/m"), [rotor], [motor], title="A drum", **options)  # type: ignore[arg-type]


def test_a_machine_built_in_python_has_a_table(tmp_path: object) -> None:
    machine = drum()
    assert machine_table(machine)["drives"] == [{"kind": "linear", "on": "drum", "slope": 0.04, "no_load_speed": 200.0}]
    assert read_back(machine, tmp_path).values == machine.values


def test_changed_values_are_in_its_settings(tmp_path: object) -> None:
    machine = drum().with_values({"drive.slope": 0.1 + 0.2, "carrier.stiffness": 123456.7})
    assert machine_table(machine)["set"] == {"drive.slope": 0.1 + 0.2, "carrier.stiffness": 123456.7}
    assert read_back(machine, tmp_path).values == machine.values


@pytest.mark.parametrize("interpolation", ["linear", "steps", "smooth"])
def test_schedules_keep_their_course(interpolation: str, tmp_path: object) -> None:
    points = [["0 s", "0 rad/s"], ["2 s", "150 rad/s"], ["3 s", "150 rad/s"], ["7.3 s", "200 rad/s"]]
    machine = drum(schedules=[{"parameter": "drive.no_load_speed", "points": points, "interpolation": interpolation}])
    (before,), (after,) = machine.schedules, read_back(machine, tmp_path).schedules
    assert after == before


def test_parts_that_were_changed_after_assembly_are_in_no_file() -> None:
    machine = load_machine("drozdetskaya-2020/r1")
    turned = machine.with_fields(start_angles=dict(machine.start_angles) | {"p1": 1.0})
    with pytest.raises(WuchtError, match="no study file can be written for this machine: its bodies begin elsewhere"):
        machine_table(turned)
