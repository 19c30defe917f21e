"""What Python shows of the fields of specs and parts: signature, section of parameters, types for checkers without a plugin."""

from __future__ import annotations

import ast
import doctest
import inspect
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from pydantic import Field
from tests.refusals import refused

import wucht
import wucht.schema
from wucht.cli.list_name import kinds
from wucht.errors import InputError
from wucht.schema import SI, TableModel, fields_of, prose_of, si
from wucht.studies.registry import studies

SOURCE = Path(wucht.__file__).parent


@cache
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


class Spring(TableModel):
    """A spring."""

    stiffness: SI[float] = si("N/m", "stiffness", "c", gt=0, help="stiffness of the spring, as measured")
    length: SI[float | None] = si("m", "free length", default=None)
    name: str = Field(description="name in results")
    turns: int = Field(default=3, ge=1, le=9, title="number of turns")
    lambda_: SI[float] = si("", "ratio", default=1.0, alias="lambda")
    ends: tuple[str, ...] = Field(default_factory=tuple)
    hidden: bool = Field(default=False, exclude=True)


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


def test_signature_and_docstring_have_the_fields() -> None:
    assert len(_tables()) > 80
    words = {"lambda": "speed_ratio", "return": "back", "from": "begin"}  # keys that are words of Python
    for name, cls in _tables().items():
        fields, signature = fields_of(cls, settable_only=True), inspect.signature(cls)
        assert not re.search(r"0x[0-9a-f]|FieldInfo|Annotated|PydanticUndefined|typing\.|wucht\.|<", str(signature)), name
        assert list(signature.parameters) == [words.get(key, key) for key in fields], name
        for parameter, field in zip(signature.parameters.values(), fields.values(), strict=True):
            default = inspect.Parameter.empty if field.is_required() else field.get_default(call_default_factory=True)
            assert parameter.default == default, name
        kinds_in_order = [p.kind for p in signature.parameters.values()]
        assert kinds_in_order == sorted(kinds_in_order), name
        text, (prose, _, section) = inspect.getdoc(cls) or "", (inspect.getdoc(cls) or "").partition("Parameters\n----------\n")
        assert prose.startswith(prose_of(cls).partition("\n")[0]) and "Parameters\n---" not in prose_of(cls), name
        assert re.findall(r"^(\w+) : ", section, re.MULTILINE) == list(signature.parameters), name
        assert not re.search(r"0x[0-9a-f]{4}", text), name


def test_fields_are_written_as_type_checkers_need_them() -> None:
    """They take a field as required whose default is not given by name, and accept texts with units by their types alone."""
    most, types = {"si": 3, "composite": 0, "Field": 0}, ("SI[", "Composite[", "Conversion[")
    found = 0
    for path in sorted(SOURCE.rglob("*.py")):
        if not re.search(r"\b(si|composite|Field)\(", text := path.read_text(encoding="utf-8")):
            continue
        for node in [n for cls in ast.parse(text).body if isinstance(cls, ast.ClassDef) for n in cls.body]:
            if isinstance(node, ast.AnnAssign) and isinstance(node.value, ast.Call) and isinstance(node.value.func, ast.Name):
                call, found = node.value, found + 1
                assert len(call.args) <= most.get(call.func.id, 9), f"{path}:{node.lineno}"
                is_quantity = call.func.id in ("si", "composite")
                assert not is_quantity or ast.unparse(node.annotation).startswith(types), f"{path}:{node.lineno}"
    assert found > 400


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


def test_the_example_holds() -> None:
    assert doctest.testmod(wucht.schema) == (0, 4)
