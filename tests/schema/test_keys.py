"""The keys of a table, from its schema: of made-up tables, and of all that a file can name."""

from __future__ import annotations

from functools import cache

import pytest
from pydantic import Field

from wucht.cli.list_name import kinds
from wucht.errors import InputError
from wucht.files.catalogue import load_machine
from wucht.files.equal_bodies import keys_in_files
from wucht.schema import TableModel, keys_of, si
from wucht.studies.registry import studies


@cache
def all_tables() -> dict[str, type[TableModel]]:
    """All that a file can name: parts, laws, followers, linkages and studies."""
    by_kind = {f"{cls.__module__}.{cls.__name__}": cls for of_kind in kinds().values() for cls in of_kind.values()}
    return by_kind | {kind: study.study for kind, study in studies().items()}


def test_every_key_of_all_that_a_file_can_name() -> None:
    """With help of three words at least; nameplate and circuit are two ways to give the same: neither alone is needed."""
    assert len(all_tables()) > 60
    for name, cls in all_tables().items():
        assert [key.name for key in keys_in_files(cls) if len(key.what.split()) < 3] == [], name
        own = [key for key in keys_of(cls) if "." not in key.name]
        fields = {f.alias or n: f for n, f in cls.model_fields.items() if not f.exclude}
        assert [key.name for key in own] == list(fields), name
        either = {key for way in cls.model_json_schema().get("anyOf", ()) for key in way["required"]}
        for key in own:
            assert "value" not in key.type, (name, key)
            assert key.needed == (fields[key.name].is_required() and key.name not in either), (name, key)


class Fan(TableModel):
    """A fan."""

    speed: float = si("rad/s", "speed", gt=0, help="speed of the shaft, at which the torque is given")
    blades: int = Field(ge=2, title="number of blades", description="number of blades, evenly spaced")
    sense: int = Field(1, description="sense of rotation, 1 or -1")


def test_help_is_not_the_name_in_sentences() -> None:
    assert [key.what for key in keys_of(Fan)] == [
        "speed of the shaft, at which the torque is given", "number of blades, evenly spaced", "sense of rotation, 1 or -1",
    ]  # fmt: skip
    for given, sentence in (
        ({"speed": -1, "blades": 2}, "Fan.speed: given -1; must be a speed greater than 0 rad/s"),
        ({"speed": 1}, "Fan.blades: this key is missing; give the number of blades"),
        ({"speed": 1, "blades": 2, "sense": "left"}, "Fan.sense: given 'left'; must be the sense of rotation, 1 or -1: "),
    ):
        with pytest.raises(InputError) as raised:
            Fan(**given)
        assert str(raised.value).startswith(sentence)


@pytest.mark.parametrize(
    ("machine", "path", "words"),
    [
        ("drozdetskaya-2020/r1", "drive.no_load_speed", "no-load speed of the drive"),
        ("drozdetskaya-2020/r1", "drive.slope", "slope of the torque-speed curve, drive"),
        ("practice/laundry-drum", "carrier.stiffness.x", "stiffness in x of the carrier"),
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
