"""The house of docs/design.md: it keeps the rules of ``house_rules.py``, each of which notices where it is broken."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from tests.house_rules import SOURCE, modules_in, reason_against, violations

from wucht.studies.registry import studies

MODULES = modules_in(SOURCE)


def test_the_house_keeps_its_rules() -> None:
    assert violations() == []


BROKEN = {
    "a floor above": ({"numerics/a.py": "from wucht.studies import b"}, "numerics must not know wucht.studies"),
    "a result in an engine": ({"dynamics/a.py": "import wucht.results.b"}, "dynamics must not know wucht.results.b"),
    "a figure that knows machines": ({"plots/a.py": "import wucht.machines.b"}, "plots must not know wucht.machines.b"),
    "a floor that draws": ({"cams/a.py": "if True:\n    from matplotlib import cm"}, "wucht.cams.a:2: cams must not draw"),
    "a circle": ({"cams/a.py": "from wucht.cams import b", "cams/b.py": "import wucht.cams.a"}, "a circle of imports"),
    "a circle hidden": ({"cams/a.py": "def f(x):\n    import wucht.errors"}, "wucht.errors is to be imported at the top"),
    "a study of a study": (
        {"studies/a.py": "from wucht.studies import b", "studies/a.toml": "", "studies/b.py": "", "studies/b.toml": ""},
        "a study imports wucht.studies.b",
    ),
    "a kind known elsewhere": ({"plots/a.py": 'x = "run-up"', "studies/run_up/template.toml": ""}, "knows the study run_up"),
    "modules of one name": ({"cams/a.py": "", "plots/a.py": ""}, "has the name of wucht.cams.a"),
    "one name of two things": ({"cams/a.py": "class X: ...", "cams/b.py": "def X(): ..."}, "X stands in wucht.cams.a as well"),
    "a share": ({"cams/a.py": "def f(x):\n    return f'{x:.1%}'"}, "a share without a space"),
    "a long line": ({"cams/a.py": "", "web/a.ts": "x".ljust(129)}, "web/a.ts:1: longer than 128"),
    "a name": ({"cams/a.py": "def f(x):\n    found = x"}, "wucht.cams.a:2: found is a loose word"),
}


@pytest.mark.parametrize(("files", "place"), BROKEN.values(), ids=BROKEN)
def test_a_broken_rule_is_noticed(tmp_path: Path, files: dict[str, str], place: str) -> None:
    for name, text in files.items():
        (tmp_path / "wucht" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "wucht" / name).write_text(text)
    places = violations(tmp_path / "wucht")
    assert len(places) == 1
    assert place in places[0]


@pytest.mark.parametrize(
    ("name", "is_function", "reason"),
    [
        ("found", False, "a loose word"),
        ("what_fits", True, "a question"),
        ("Tried", True, "a participle"),
        ("others", False, "a pronoun"),
        ("after_resonance", True, "a preposition"),
        ("after_resonance", False, ""),
        ("__add__", True, ""),
    ],
)
def test_what_is_no_name(name: str, is_function: bool, reason: str) -> None:
    assert reason_against(name, is_function) == reason


@cache
def _definitions(module: str) -> dict[str, ast.stmt]:
    """What a module defines or imports at its top, by name."""
    found: dict[str, ast.stmt] = {}
    body = MODULES[module].tree.body
    for node in [inner for one in body for inner in (one.body if isinstance(one, ast.If) else [one])]:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found[node.name] = node
            methods = node.body if isinstance(node, ast.ClassDef) else []
            found |= {f"{node.name}.{m.name}": m for m in methods if isinstance(m, ast.FunctionDef)}
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                found |= {n.id: node for n in ast.walk(target) if isinstance(n, ast.Name)}
        elif isinstance(node, ast.Import | ast.ImportFrom):
            found |= {(a.asname or a.name).split(".")[0]: node for a in node.names}
    return found


def _used_by(module: str, name: str, own: str) -> set[str]:
    """The modules of wucht that a function uses, whatever it calls in the modules of ``own`` on its way."""
    modules, done, pending = set[str](), set[tuple[str, str]](), [(module, name)]
    while pending:
        where, what = pending.pop()
        node = _definitions(where).get(what)
        if node is None or (where, what) in done:
            continue
        done.add((where, what))
        if not isinstance(node, ast.Import | ast.ImportFrom):
            pending += [(where, n.id) for n in ast.walk(node) if isinstance(n, ast.Name)]
        elif isinstance(node, ast.ImportFrom) and str(node.module).startswith("wucht"):
            inside = f"{node.module}.{what}"
            if inside in MODULES:
                modules.add(inside)
            elif str(node.module) == own or str(node.module).startswith(f"{own}."):
                pending.append((str(node.module), what))
            else:
                modules.add(str(node.module))
    return modules


def test_a_figure_knows_the_dataset_alone() -> None:
    for kind, entry in studies().items():
        module, drawing = entry.study.__module__, f"{entry.study.__name__}.draw"
        assert drawing in _definitions(module), kind
        used = _used_by(module, drawing, module.removesuffix(".study"))
        assert used, kind
        assert {m for m in used if m.split(".")[1] not in ("plots", "results", "errors")} == set(), kind


@pytest.mark.parametrize(
    "name",
    [
        "parts",
    ],
)
def test_a_name_of_the_package_is_there_whatever_was_loaded_before(name: str) -> None:
    code = f"import wucht; print(wucht.{name}.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().rpartition(".")[2] == name


def test_a_study_is_loaded_without_what_draws_and_stores() -> None:
    """`wucht list` loads all of them."""
    code = "import sys; from wucht.studies.registry import studies; [s.study for s in studies().values()]; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"matplotlib", "xarray", "pandas"} & set(done.stdout.split())


def test_importing_wucht_loads_nothing_heavy() -> None:
    heavy = {"numpy", "sympy", "llvmlite", "xarray", "pint", "matplotlib", "pydantic"}
    code = f"import sys, wucht; print(sorted({heavy} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
