"""The public names, from their docstrings."""

from __future__ import annotations

import re
from pathlib import Path

import wucht
from wucht.studies.registry import studies

_STUB, _PUBLIC = Path(wucht.__file__).with_suffix(".pyi"), re.compile(r"^from (\S+) import (\w+) as", re.MULTILINE)
_RUNNING = ("run", "run_file", "compare", "grid", "load", "draw", "panel_names", "report", "write_report", "export")


def page() -> str:
    """Every name of ``wucht.__all__`` once, by what it is for."""
    questions = [study.study.__name__ for study in studies().values() if study.package.startswith("wucht.")]
    names = _PUBLIC.findall(_STUB.read_text(encoding="utf-8"))
    public = {name: f"wucht{module}.{name}" for module, name in sorted(names, key=lambda n: n[1])}
    groups = {
        "Ask and answer": [n for n in _RUNNING if n in public],
        "Machines and equations": ["load_machine", "Machine", "parts", "load_equations", "UserSystem", "CamDrive", "Records"],
        "Errors": ["WuchtError", "InputError", "RunError"],
        "Questions": sorted(n for n in questions if n in public),
    }
    told = {n for within in groups.values() for n in within}
    groups["Any ordinary differential equation"] = [n for n in public if n not in told]
    lines = ["# Python", "", "```python", "import wucht", "```", ""]
    lines += ["All that stands here is `wucht.NAME`. Quantities are numbers in SI, or text with a unit.", ""]
    for title, within in groups.items():
        lines += [f"## {title}", ""]
        for name in within:
            lines += [f"::: {public[name]}", "    options:", "      heading_level: 3", ""]
    return "\n".join(lines)
