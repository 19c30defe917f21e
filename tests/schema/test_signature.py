"""What Python shows of the fields of specs and parts: signature, section of parameters, types for checkers without a plugin."""

from __future__ import annotations

import ast
import doctest
import inspect
import json
import pydoc
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from pydantic import Field
from tests.refusals import refused

import wucht
from wucht.cli.list_name import kinds
from wucht.errors import InputError
from wucht.machines import parts
from wucht.schema import SI, TableModel, fields_of, keys_of, prose_of, si, unit_of
from wucht.studies.registry import studies

SOURCE = Path(wucht.__file__).parent


def _tables() -> dict[str, type[TableModel]]:
    """All tables of wucht: specs, parts, tables of cams, and those inside."""
    _ = kinds(), [study.study for study in studies().values()]
    pending, tables = [TableModel], dict[str, type[TableModel]]()
    while pending:
        one = pending.pop()
        pending += one.__subclasses__()
        if one.__module__.startswith("wucht."):
            tables[f"{one.__module__}.{one.__qualname__}"] = one
    return tables


TABLES = _tables()


class Spring(TableModel):
    """A spring.

    It is linear.

    Examples
    --------
    >>> 1 + 1
    2
    """

    stiffness: SI[float] = si("N/m", "stiffness", "c", gt=0, help="stiffness of the spring, as measured")
    length: SI[float | None] = si("m", "free length", default=None)
    name: str = Field(description="name in results")
    turns: int = Field(default=3, ge=1, le=9, title="number of turns")
    lambda_: SI[float] = si("", "ratio", default=1.0, alias="lambda")
    ends: tuple[str, ...] = Field(default_factory=tuple)
    hidden: bool = Field(default=False, exclude=True)


class Plain(TableModel):
    size: int = 1


def test_signature_by_hand() -> None:
    assert str(inspect.signature(Spring)) == (
        "(stiffness: float | str, length: float | str | None = None, *, name: str, turns: int = 3, lambda_: float | str = 1.0, "
        "ends: tuple[str, ...] = ())"
    )
    spring = Spring("2 N/m", name="left", lambda_=2.0)
    assert (spring.stiffness, spring.length, spring.lambda_) == (2.0, None, 2.0)
    assert Spring("2 N/m", name="left", **{"lambda": 2.0}) == spring
    assert str(inspect.signature(Spring)).startswith("(stiffness: float | str"), "pydantic sets none when it is built"
    with pytest.raises(InputError, match=r"Spring.lambda: given -'a'|Spring.lambda: given 'a'"):
        Spring(1.0, name="left", lambda_="a")


def test_section_by_hand() -> None:
    assert inspect.getdoc(Spring) == (
        "A spring.\n\nIt is linear.\n\nParameters\n----------\n"
        "stiffness : float | str\n    stiffness of the spring, as measured [N/m, > 0]\n"
        "length : float | str | None, optional\n    free length [m]\n"
        "name : str\n    name in results\n"
        "turns : int, default 3\n    number of turns [>= 1, <= 9]\n"
        "lambda_ : float | str, default 1.0\n    ratio\n"
        "ends : tuple[str, ...], optional\n\n"
        "Examples\n--------\n>>> 1 + 1\n2"
    )
    assert prose_of(Spring).startswith("A spring.\n\nIt is linear.\n\nExamples")
    assert "stiffness of the spring" in pydoc.render_doc(Spring)
    assert Spring(1.0, name="left").__doc__ == vars(Spring)["__doc__"]
    assert (prose_of(Plain), Plain.__doc__) == ("", "Parameters\n----------\nsize : int, default 1\n")
    assert (TableModel.__doc__, prose_of(TableModel)) == (prose_of(TableModel), inspect.getdoc(TableModel))
    assert doctest.DocTestFinder().find(Spring)[0].examples[0].want == "2\n"


def test_docstring_can_be_replaced() -> None:
    class Part(TableModel):
        """A part."""

        size: int = 1

    Part.__doc__ = "Another part."
    assert (prose_of(Part), inspect.getdoc(Part)) == (
        "Another part.",
        "Another part.\n\nParameters\n----------\nsize : int, default 1",
    )


def test_schema_has_no_section() -> None:
    assert Spring.model_json_schema()["description"] == prose_of(Spring)
    assert "description" not in Plain.model_json_schema()
    assert "Parameters\n" not in json.dumps([table.model_json_schema() for table in (wucht.RunUp, wucht.parts.Rotor)])


@pytest.mark.parametrize("name", TABLES)
def test_signature_equals_the_fields(name: str) -> None:
    cls = TABLES[name]
    fields, signature = fields_of(cls, settable_only=True), inspect.signature(cls)
    assert not re.search(r"0x[0-9a-f]|FieldInfo|Annotated|PydanticUndefined|typing\.|wucht\.|<", str(signature))
    words = {"lambda": "speed_ratio", "return": "back"}  # keys that are words of Python
    assert list(signature.parameters) == [words.get(key, key) for key in fields]
    for parameter, field in zip(signature.parameters.values(), fields.values(), strict=True):
        assert (parameter.default is inspect.Parameter.empty) == field.is_required()
        if not field.is_required():
            assert parameter.default == field.get_default(call_default_factory=True)
    required_later = [p.kind for p in signature.parameters.values()]
    assert required_later == sorted(required_later)


@pytest.mark.parametrize("name", TABLES)
def test_section_has_all_parameters(name: str) -> None:
    cls = TABLES[name]
    text, parameters = inspect.getdoc(cls) or "", list(inspect.signature(cls).parameters)
    assert text.count("Parameters\n----------\n") == bool(parameters)
    assert prose_of(cls).count("Parameters\n---") == 0
    assert text.startswith(prose_of(cls).partition("\n")[0])
    section = text.partition("Parameters\n----------\n")[2]
    assert re.findall(r"^(\w+) : ", section, re.MULTILINE) == parameters
    assert not re.search(r"0x[0-9a-f]{4}", section)


@pytest.mark.parametrize("name", ["run-up", "stability-map", "rotor", "induction", "harmonic"])
def test_section_has_the_help_and_unit_of_each_key(name: str) -> None:
    by_kind = {kind: cls for of_kind in kinds().values() for kind, cls in of_kind.items()}
    cls: Any = by_kind.get(name) or studies()[name].study
    words = " ".join(inspect.getdoc(cls).split())
    units = {key: unit_of(field) for key, field in fields_of(cls).items()}
    for key in keys_of(cls):
        if "." not in key.name:
            assert " ".join(key.what.split()) in words
            assert units[key.name] is None or not key.unit or f"[{key.unit}" in words


def test_no_public_signature_has_an_address() -> None:
    for name in wucht.__all__:
        public = getattr(wucht, name)
        if callable(public):
            assert " at 0x" not in str(inspect.signature(public)), name


def test_commands_print_no_section(wucht: Any) -> None:
    printed = wucht("list", "rotor").out
    assert printed.count("mass of the rotor with its unbalance") == 1
    assert "Parameters" not in printed + studies()["run-up"].template + studies()["run-up"].line


@cache
def _fields() -> dict[str, Any]:
    """The fields in the source by their places."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(SOURCE.rglob("*.py"))}
    return {
        f"{path.relative_to(SOURCE)}:{node.lineno}": node
        for path, text in texts.items()
        if re.search(r"\b(si|composite|Field)\(", text)
        for cls in ast.parse(text).body
        if isinstance(cls, ast.ClassDef)
        for node in cls.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.value, ast.Call) and isinstance(node.value.func, ast.Name)
    }


def test_defaults_are_given_by_name() -> None:
    """Type checkers take a field as required whose default is not."""
    most = {"si": 3, "composite": 0, "Field": 0}
    calls = {place: node.value for place, node in _fields().items()}
    assert len(calls) > 400
    assert [place for place, call in calls.items() if len(call.args) > most.get(call.func.id, 9)] == []


def test_quantities_are_annotated_as_such() -> None:
    """Type checkers accept texts with units, lists and tables by these types alone."""
    special = [(place, node) for place, node in _fields().items() if node.value.func.id in ("si", "composite")]
    types = ("SI[", "Composite[", "Conversion[")
    assert [place for place, node in special if not ast.unparse(node.annotation).startswith(types)] == []


def test_type_checkers_know_all_parts() -> None:
    source = Path(parts.__file__).read_text(encoding="utf-8")
    listed = set(re.findall(r"^    from wucht\.machines\.parts\.\w+ import (\w+) as \1$", source, re.MULTILINE))
    assert listed == {name for name, cls in parts._classes().items() if cls.__module__.startswith("wucht.machines.parts.")}


_ASKED = """
import wucht
from wucht.extending import SI, Drive, si

class Motor(Drive):
    stall: SI[float] = si("N m", "torque at standstill", "T_0", gt=0)
    ratio: SI[float | None] = si("", "ratio", default=None)

# accepted
wucht.RunUp()
wucht.RunUp(until=20.0)
wucht.RunUp(until="20 s", start={"p1": 0.3}, along="drive.slope", values=[1, "2 N m s"], inertia=None, model="slow")
wucht.RunUp(until={"turns": 300})
wucht.SpeedCurve(along="drive.slope", range=["1 N m s", 2.0], only="compensating")
rotor = wucht.parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia=0.03, release={"time": "3 s"})
mass: float = rotor.mass
eccentricity: float | None = rotor.eccentricity
wucht.parts.Carrier(stiffness=("1e5 N/m", 2e5), damping=200)
Motor(on="drum", stall="2 N m")
# refused
wucht.RunUp(untill=20.0)
wucht.RunUp(model="fast")
wucht.parts.Rotor(name="drum", mas="9 kg", mass=1, inertia=1)
wucht.parts.Rotor(name="drum", mass="9 kg")
text: str = rotor.mass
Motor(on="drum", stal=2)
"""


def test_no_value_by_position_is_dropped() -> None:
    """Neither a surplus one nor one that is given by name too."""
    assert wucht.RunUp(20.0).until == wucht.RunUp(until=20.0).until
    with refused("study", "by position", given=99, code="too-many"):
        wucht.RunUp(*[1.0] * 99)
    first = next(iter(inspect.signature(wucht.parts.Rotor).parameters))
    with refused(f"rotor.{first}", "by position", code="given-twice"):
        wucht.parts.Rotor("drum", **{first: "other"}, mass=1.0, eccentricity=0.0, inertia=1.0)


@pytest.mark.slow
def test_mypy_without_a_plugin(tmp_path: Path) -> None:
    """It accepts what the tables accept, and refuses misspelt keys and other types."""
    pytest.importorskip("mypy")
    (tmp_path / "asked.py").write_text(_ASKED, encoding="utf-8")
    (tmp_path / "mypy.ini").write_text("[mypy]\nfollow_imports = silent\n", encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--config-file", "mypy.ini", "--cache-dir", str(tmp_path / "cache"), "asked.py"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    lines = re.findall(r"^asked\.py:(\d+): error: (.*)", done.stdout, re.MULTILINE)
    refused = _ASKED.splitlines().index("# refused") + 2
    expected = ['"untill" for "RunUp"', '"model" to "RunUp"', '"mas" for "Rotor"', 'argument "inertia"', "in assignment"]
    assert [int(line) for line, _ in lines] == [*range(refused, refused + 6)], done.stdout
    assert [sentence for sentence, (_, text) in zip(expected, lines, strict=False) if sentence not in text] == []
