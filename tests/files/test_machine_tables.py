"""The table of a machine from its parts: the same machine is read back, whatever it was built from."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from wucht import Machine, load_machine, parts
from wucht.errors import WuchtError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_document, names
from wucht.files.documents import document_of, refuse_bare_frequencies
from wucht.files.machine_tables import machine_table
from wucht.files.toml_text import abridge, toml_text
from wucht.studies.study_file import read_study
from wucht.studies.subjects import subject_of


def read_back(machine: Machine, tmp_path: object) -> Machine:
    text = toml_text({"machine": machine_table(machine)})
    document = document_of(text, tmp_path)  # type: ignore[arg-type]
    refuse_bare_frequencies(document["machine"], "machine")
    return machine_from(document["machine"])


@pytest.mark.slow
def test_every_machine_of_the_catalogue_is_read_back(tmp_path: object) -> None:
    """With its equations, of one with mounts, material and two drives; equal values and parts have equal ones."""
    machines = [name for name in names() if "machine" in load_document(name)[0]]
    assert "practice/screen-loaded" in machines
    for name in machines:
        machine = load_machine(name)
        copy = read_back(machine, tmp_path)
        assert copy.values == machine.values, name
        assert copy.start_angles == machine.start_angles, name
        assert name != "practice/screen-loaded" or copy.system == machine.system, name


def drum(**options: object) -> Machine:
    rotor = parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2")
    motor = parts.LinearDrive(slope="0.04 N m s", no_load_speed="200 rad/s")
    return Machine(parts.Carrier(mass="1 kg", stiffness="1e5 N/m"), [rotor], [motor], title="A drum", **options)  # type: ignore[arg-type]


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


_TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
_SINGLE = st.one_of(_TEXT, st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False))
_VALUES = st.recursive(
    _SINGLE, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_TEXT, inner, max_size=3), max_leaves=12
)


# The first text on a machine builds Hypothesis' table of Unicode, which takes longer than it allows for a draw.
@settings(suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(_TEXT, _VALUES, max_size=4))
def test_any_document_reads_back(document: dict[str, object]) -> None:
    assert tomllib.loads(toml_text(document)) == document


def test_what_is_long_is_counted() -> None:
    short = abridge({"text": "x" * 30, "list": list(range(9)), "tables": [{"a": k} for k in range(9)], "few": [1]}, 10, 2)
    assert short == {
        "text": "x" * 10 + "… (20 more characters)",
        "list": [0, 1, "… 7 more"],
        "tables": [{"a": 0}, {"a": 1}, {"abridged": "… 7 more"}],
        "few": [1],
    }
    assert tomllib.loads(toml_text(short)) == short


@pytest.mark.slow
def test_the_study_file_of_a_result_asks_the_same(tmp_path: Path) -> None:
    for name in (n for n in names() if n.startswith(("practice/", "kaltofen", "sperling-rollers/"))):
        first = read_study(name)
        file = tmp_path / "again.toml"
        file.write_text(toml_text(json.loads(json.dumps(first.document, default=str))), encoding="utf-8")
        again = read_study(str(file))
        subject = subject_of(first.spec)
        both = (dict(subject.describe(study.subject).facts) for study in (first, again))
        facts = [{k: v for k, v in of.items() if k != "title"} for of in both]
        assert facts[0] == facts[1], name
        assert first.spec.to_table() == again.spec.to_table(), name
