"""The help of every key of all that a file can name: stated by its field, and nowhere else."""

from __future__ import annotations

import re

import pytest
from pydantic import BaseModel, Field

from wucht.cli.list_name import kinds
from wucht.errors import InputError
from wucht.files.equal_bodies import keys_in_files
from wucht.schema import TableModel, keys_of, models_in, prose_of, si
from wucht.studies.registry import studies

EVERY = {f"{cls.__module__}.{cls.__name__}": cls for of_kind in kinds().values() for cls in of_kind.values()}
EVERY |= {kind: study.study for kind, study in studies().items()}


def _with_tables(cls: type[BaseModel]) -> set[type[BaseModel]]:
    """A table, those inside, and those that they inherit keys from."""
    found, pending = set[type[BaseModel]](), [cls]
    while pending:
        one = pending.pop()
        if one not in found:
            found.add(one)
            pending += [m for field in one.model_fields.values() for m in models_in(field.annotation)]
            pending += [base for base in one.__bases__ if issubclass(base, TableModel)]
    return found


@pytest.mark.parametrize("name", EVERY)
def test_every_key_has_help(name: str) -> None:
    assert [key.name for key in keys_in_files(EVERY[name]) if len(key.what.split()) < 3] == []


@pytest.mark.parametrize("name", EVERY)
def test_no_docstring_describes_keys(name: str) -> None:
    for cls in _with_tables(EVERY[name]):
        keys = "|".join(map(re.escape, cls.model_fields)) or "(?!)"
        assert re.findall(rf"(?:^|[.;:,] |`)((?:{keys})`*: )", " ".join(prose_of(cls).split())) == [], cls


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
