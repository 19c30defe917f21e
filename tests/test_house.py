"""The house of docs/design.md: each floor knows only the floors below it, and importing wucht loads none of them."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).parent.parent / "src" / "wucht"
FLOORS = ["errors", "quantities", "piecewise", "system", "documents", "results", "numerics", "mechanics", "machines", "studies"]
ALLOWED = {floor: set(FLOORS[: FLOORS.index(floor) + 1]) for floor in FLOORS}
ALLOWED["plots"] = {"errors", "plots"}  # a figure is drawn from a Dataset and nothing else
ALLOWED["cli"] = {*FLOORS, "plots", "cli"}


def _imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [a.name for a in node.names] if isinstance(node, ast.Import) else []
        found |= {n.split(".")[1] for n in names if n.startswith("wucht.")}
    return found


@pytest.mark.parametrize("path", sorted(SOURCE.rglob("*.py")), ids=lambda p: str(p.relative_to(SOURCE)))
def test_each_floor_knows_only_those_below(path: Path) -> None:
    floor = path.relative_to(SOURCE).parts[0].removesuffix(".py")
    if floor in ("__init__", "__main__"):
        return
    assert _imports(path) <= ALLOWED[floor]


def test_importing_wucht_loads_nothing_heavy() -> None:
    heavy = {"numpy", "sympy", "heyoka", "xarray", "pint", "matplotlib", "pydantic"}
    code = f"import sys, wucht; print(sorted({heavy} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
