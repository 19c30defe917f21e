"""The house of docs/design.md: each floor knows only those below it, there is no circle, and importing wucht loads nothing."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

SOURCE = Path(__file__).parent.parent / "src" / "wucht"
FLOORS = [
    "errors", "schema", "disk_cache", "file_names", "piecewise", "system", "kinds", "results", "numerics", "fatigue",
    "mechanics", "machines", "files", "analysis", "measurements", "cams", "dynamics", "plots", "studies", "extending", "cli",
]  # fmt: skip
ALLOWED = {floor: set(FLOORS[: FLOORS.index(floor) + 1]) for floor in FLOORS}
MODULES = {path.relative_to(SOURCE.parent).with_suffix("").as_posix().replace("/", ".").removesuffix(".__init__"): path
           for path in sorted(SOURCE.rglob("*.py"))}  # fmt: skip
STUDIES = sorted(p.parent.name for p in (SOURCE / "studies").glob("*/spec.py"))


@cache
def _nodes(path: Path) -> tuple[list[ast.AST], list[ast.AST]]:
    """The imports of a file: all of them, and those within functions."""
    every: list[ast.AST] = []
    inside: list[ast.AST] = []
    pending: list[tuple[ast.AST, bool]] = [(ast.parse(_text(path)), False)]
    while pending:
        node, within = pending.pop()
        within = within or isinstance(node, ast.FunctionDef)
        if isinstance(node, ast.Import | ast.ImportFrom):
            every.append(node)
            inside += [node] * within
        pending += [
            (child, within)
            for child in ast.iter_child_nodes(node)
            if isinstance(child, ast.stmt | ast.excepthandler | ast.match_case)
        ]
    return every, inside


def _imports(path: Path, in_functions: bool = False) -> set[str]:
    """The modules of wucht that a file imports, whether for types, in functions or at the top."""
    names: set[str] = set()
    for node in _nodes(path)[in_functions]:
        if isinstance(node, ast.Import):
            names |= {a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {
                f"{node.module}.{a.name}" if f"{node.module}.{a.name}" in MODULES else str(node.module) for a in node.names
            }
    return {n for n in names if n.split(".")[0] == "wucht"}


@cache
def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _floor(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


@pytest.mark.parametrize("module", MODULES)
def test_each_floor_knows_only_those_below(module: str) -> None:
    if _floor(module) in ("", "__main__"):
        return
    assert {_floor(m) for m in _imports(MODULES[module])} - {""} <= ALLOWED[_floor(module)]


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) == "dynamics"])
def test_engines_know_no_spec_and_no_figure(module: str) -> None:
    assert {m for m in _imports(MODULES[module]) if _floor(m) in ("results", "studies", "cli")} == set()


def test_no_files_import_each_other_in_a_circle() -> None:
    edges = {m: {i for i in _imports(path) if i in MODULES and i != m} for m, path in MODULES.items()}
    reach: dict[str, set[str]] = {}
    for module in MODULES:
        seen, pending = set[str](), [module]
        while pending:
            for other in edges[pending.pop()] - seen:
                seen.add(other)
                pending.append(other)
        reach[module] = seen
    assert [m for m in MODULES if m in reach[m]] == []


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) not in ("", "cli", "__main__")])
def test_no_import_within_a_function_hides_a_circle(module: str) -> None:
    """Engines are loaded when they are asked for; all else of ours is imported at the top."""
    engines = {"wucht.numerics.flow.heyoka_engine", "wucht.numerics.flow.scipy_engine"}
    assert _imports(MODULES[module], in_functions=True) - engines == set()


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) == "plots"])
def test_plots_know_datasets_alone(module: str) -> None:
    assert {_floor(m) for m in _imports(MODULES[module])} <= {"plots", "results", "file_names", "errors"}


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) not in ("plots", "studies", "cli", "extending", "")])
def test_what_lies_below_the_plots_draws_nothing(module: str) -> None:
    names = {a.name for node in _nodes(MODULES[module])[0] if isinstance(node, ast.Import) for a in node.names}
    names |= {str(node.module) for node in _nodes(MODULES[module])[0] if isinstance(node, ast.ImportFrom)}
    assert not {n for n in names if n.split(".")[0] == "matplotlib"}


@pytest.mark.parametrize("study", STUDIES)
def test_figures_and_reports_know_datasets_alone(study: str) -> None:
    folder = SOURCE / "studies" / study
    own = {f"wucht.studies.{study}.{p.stem}" for pattern in ("figure*.py", "report*.py") for p in folder.glob(pattern)}
    for module in own:
        others = {m for m in _imports(MODULES[module]) if _floor(m) not in ("plots", "results", "errors")}
        assert others <= own, module


@pytest.mark.parametrize("study", STUDIES)
def test_specs_know_no_machine(study: str) -> None:
    floors = {_floor(m) for m in _imports(MODULES[f"wucht.studies.{study}.spec"])}
    assert not floors & {"machines", "files", "analysis"}


@pytest.mark.parametrize("study", STUDIES)
def test_no_study_imports_another(study: str) -> None:
    """What two of them need is an engine, or shared keys, and lies below them."""
    others = {
        f"{module} imports {name}"
        for module, path in MODULES.items()
        if module.startswith(f"wucht.studies.{study}.")
        for name in _imports(path)
        if name.startswith("wucht.studies.") and name.split(".")[2] in set(STUDIES) - {study}
    }
    assert others == set()


@pytest.mark.parametrize("study", STUDIES)
def test_a_study_is_one_folder(study: str) -> None:
    parts = {p.name for p in (SOURCE / "studies" / study).iterdir()}
    assert {"spec.py", "prepare.py", "run.py", "dataset.py", "figure.py", "report.py", "template.toml"} <= parts
    words = (f"studies.{study}", f'"{study.replace("_", "-")}"')
    elsewhere = {m for m, path in MODULES.items() if f".studies.{study}" not in m and any(w in _text(path) for w in words)}
    assert {m for m in elsewhere if _floor(m) != "studies" and m != "wucht"} == set(), "nothing outside the studies knows it"


def test_no_two_modules_bear_one_name() -> None:
    of_every_study = {"spec", "prepare", "run", "dataset", "figure", "report", "export", "__init__"}
    names = [path.stem for m, path in MODULES.items() if path.stem not in of_every_study and _floor(m) != "cli"]
    assert sorted({n for n in names if names.count(n) > 1}) == []


def test_importing_wucht_loads_nothing_heavy() -> None:
    heavy = {"numpy", "sympy", "heyoka", "xarray", "pint", "matplotlib", "pydantic"}
    code = f"import sys, wucht; print(sorted({heavy} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
