"""Parameters in words, from the descriptions of the fields: one home for labels and sentences."""

from __future__ import annotations

import pytest

from wucht.files.catalogue import load_machine
from wucht.schema import Parameter, full_name


@pytest.mark.parametrize(
    ("machine", "path", "words"),
    [
        ("drozdetskaya-2020/r1", "drive.no_load_speed", "no-load speed of the drive"),
        ("drozdetskaya-2020/r1", "drive.slope", "slope of the torque-speed curve, drive"),
        ("drozdetskaya-2020/r1", "drum.eccentricity", "eccentricity of drum"),
        ("practice/laundry-drum", "carrier.stiffness.x", "stiffness in x of the carrier"),
        ("practice/laundry-drum", "carrier.gravity", "acceleration of gravity"),
        ("practice/laundry-drum", "load.coefficient", "coefficient of the load"),
        ("practice/screen", "drives.e1.voltage", "voltage of a phase, drive of e1"),
        ("practice/screen", "carrier.mounts.1.at.x", "place in x of mount 1"),
        ("sperling-vibration/figure-2a", "carrier.motion.amplitude", "amplitude of the motion of the carrier"),
    ],
)
def test_what_it_is_and_whose(machine: str, path: str, words: str) -> None:
    parameter = load_machine(machine).parameters[path]
    assert parameter.full_name == parameter.sentence_name == words


def test_every_parameter_of_the_catalogue_has_words_of_its_own() -> None:
    for machine in ("practice/laundry-drum", "practice/screen"):
        parameters = load_machine(machine).parameters.values()
        assert len({p.full_name for p in parameters}) == len(parameters)
        assert not [p.full_name for p in parameters if "_" in p.full_name]


def test_a_symbol_stays_one() -> None:
    u = load_machine("drozdetskaya-2020/table-5.1").parameters["u"]
    assert (u.sentence_name, u.value_text(2.5)) == ("u", "u = 2.5")


def test_a_value_has_its_unit() -> None:
    assert Parameter("drive.voltage", 1.0, "V", "U", "voltage").value_text(230.0) == "voltage of the drive = 230 V"


def test_a_letter_within_a_word_is_no_owner() -> None:
    assert full_name("a.mass", "mass") == "mass of a"
