"""docs/api/public.txt: what it lists is there and is called so, nothing else is exported, pages and examples need no more.

Names of earlier versions (``wucht.earlier_names``) give the present ones, with a warning.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.public_names import LIST, PACKAGES, exported_names, line_of, listed_lines, package_of

ROOT = LIST.parents[2]
LISTED = listed_lines()


@pytest.mark.parametrize("package", PACKAGES)
def test_every_exported_name_is_listed(package: str) -> None:
    """And no other: an addition is an edit of the list, too (``python -m tests.public_names NAME``)."""
    listed = {name.removeprefix(f"{package}.") for name in LISTED if package_of(name) == package}
    assert {name for name in listed if "." not in name} == exported_names(package)


def test_listed_lines_are_true() -> None:
    """A name alone states only that it is there."""
    false = {line: line_of(name) for name, line in LISTED.items() if line != line_of(name) and line != name}
    assert false == {}


def _shown_code() -> Iterator[tuple[str, str]]:
    """What readers run: examples, and the Python of pages and notebooks."""
    for path in sorted((ROOT / "examples").glob("*.py")):
        yield path.name, path.read_text(encoding="utf-8")
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for block in re.findall(r"^```python\n(.*?)^```", path.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
            yield path.name, block
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        lines = [line for cell in cells if cell["cell_type"] == "code" for line in "".join(cell["source"]).splitlines()]
        yield path.name, "\n".join(line for line in lines if not line.startswith("%"))


def _names_used(code: str) -> Iterator[str]:
    """Names of ours that code imports, and attributes of wucht and its parts."""
    for node in ast.walk(ast.parse(code)):
        match node:
            case ast.ImportFrom(module=str(module)) if module.split(".")[0] == "wucht":
                yield from (f"{module}.{alias.name}" for alias in node.names)
            case ast.Import():
                yield from (alias.name for alias in node.names if alias.name.startswith("wucht."))
            case ast.Attribute(value=ast.Name(id="wucht"), attr=name):
                yield f"wucht.{name}"
            case ast.Attribute(value=ast.Name(id="parts"), attr=name) if name[0].isupper():
                yield f"wucht.parts.{name}"


def test_pages_and_examples_import_only_what_is_listed() -> None:
    used = {(name, place) for place, code in _shown_code() for name in _names_used(code)}
    assert len({name for name, _ in used}) > 50
    allowed = {*LISTED, *PACKAGES, "wucht.__version__"}
    assert {(name, place) for name, place in used if name not in allowed} == set()


# What pages and examples of earlier versions imported, and what it is now.
EARLIER = {
    "wucht.OwnEquations": "wucht.UserSystem",
    "wucht.cams.laws.standard_laws.of_polynomials": "wucht.cams.polynomial_law",
    "wucht.extending.Quantity": "wucht.extending_0_1.Quantity",
    "wucht.extending.ReportLines": "wucht.extending_0_1.ReportLines",
    "wucht.extending.Spec": "wucht.extending_0_1.Spec",
    "wucht.extending.answer": "wucht.extending_0_1.result_dataset",
    "wucht.extending.formats": "wucht.extending_0_1.formats",
    "wucht.extending.in_lines": "wucht.extending_0_1.report_lines",
    "wucht.extending.report_lines": "wucht.extending_0_1.report_lines",
    "wucht.extending.result_dataset": "wucht.extending_0_1.result_dataset",
    "wucht.extending.table": "wucht.extending_0_1.table",
    "wucht.mechanics.averaging.Averaged": "wucht.mechanics.Averaging",
    "wucht.mechanics.harmonics": "wucht.mechanics.trigonometric_polynomial",
    "wucht.numerics.collocation.boundary_values.at_begin": "wucht.numerics.periodic.start_value",
    "wucht.numerics.collocation.boundary_values.at_end": "wucht.numerics.periodic.end_value",
    "wucht.numerics.continuation.Equations": "wucht.numerics.continuation.EquilibriumEquations",
    "wucht.numerics.continuation.Equilibria": "wucht.numerics.continuation.EquilibriumContinuation",
    "wucht.numerics.continuation.equations.Equations": "wucht.numerics.continuation.EquilibriumEquations",
    "wucht.numerics.continuation.equations.Functions": "wucht.numerics.continuation.FunctionProblem",
    "wucht.numerics.continuation.equilibria.Equilibria": "wucht.numerics.continuation.EquilibriumContinuation",
    "wucht.numerics.flow.compiled.compile_system": "wucht.compile_system",
    "wucht.numerics.periodic.connection_starts.of_excursion": "wucht.numerics.periodic.connection_from_excursion",
    "wucht.numerics.periodic.cycle_starts.doubled": "wucht.numerics.periodic.doubled_branch",
}


def _attribute(path: str) -> Any:
    module, _, name = path.rpartition(".")
    return getattr(import_module(module), name)


@pytest.mark.parametrize(("earlier", "present"), EARLIER.items())
def test_an_earlier_name_warns_and_is_the_present_one(earlier: str, present: str) -> None:
    assert present in LISTED
    with pytest.warns(
        DeprecationWarning, match=rf"{re.escape(earlier)} is now wucht\.\S*{present.rpartition('.')[2]};"
    ) as seen:
        value = _attribute(earlier)
    assert value is _attribute(present)
    assert {Path(warning.filename).name for warning in seen} == {Path(__file__).name}


def test_an_earlier_attribute_warns() -> None:
    from wucht.numerics.continuation import EquilibriumEquations
    from wucht.numerics.flow import Trajectory

    with pytest.warns(DeprecationWarning, match=r"EquilibriumEquations\.of is now EquilibriumEquations\.from_system;"):
        assert EquilibriumEquations.of == EquilibriumEquations.from_system
    empty = Trajectory(np.zeros(1), np.zeros((1, 1)), {}, np.ones(2), 0.0, np.zeros(1))
    with pytest.warns(DeprecationWarning, match=r"Trajectory\.parameters is now Trajectory\.final_parameter_values;"):
        assert np.array_equal(empty.parameters, [1.0, 1.0])
