"""Formulas in pages that the program prints: at ``<!-- equations: FILE OPTIONS -->`` and ``<!-- energies: FILE -->``.

FILE is a name of the catalogue, or a file that the page itself has: a block of TOML with a title.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import sympy as sp

from wucht.files.catalogue import load_machine
from wucht.machines.symbols import notation_of
from wucht.mechanics.energies import Energies

_MARK = re.compile(r"^<!-- (equations|energies): (\S+)(.*) -->$", re.MULTILINE)
_BEGIN, _END = "$$\n\\begin{align*}", "\\end{align*}\n$$"
_FILE = re.compile(r'^```toml title="(.+?)"\n(.*?)^```$', re.MULTILINE | re.DOTALL)


def with_equations(page: str) -> str:
    """A page with its marks replaced by formulas. Raises ``CalledProcessError`` or ``InputError`` for a wrong one."""
    if not _MARK.search(page):
        return page
    with tempfile.TemporaryDirectory() as folder:
        for title, text in _FILE.findall(page):
            (Path(folder) / title).write_text(text, encoding="utf-8")
        return _MARK.sub(lambda mark: _formulas(Path(folder), *mark.groups()), page)


def _formulas(folder: Path, what: str, name: str, options: str) -> str:
    own = folder / name
    of = str(own) if own.is_file() else name
    return _energies(of) if what == "energies" else _equations([of, *shlex.split(options)])


def _equations(words: list[str]) -> str:
    """What ``wucht equations`` prints, its formulas as display formulas, without the list of values."""
    command = [sys.executable, "-m", "wucht", "equations", *words, "--latex"]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    shown = said.replace("\\begin{align}", f"\n{_BEGIN}").replace("\\end{align}", f"{_END}\n")
    values = (line.startswith("% ") and " = " in line for line in shown.splitlines())
    lines = [line for line, value in zip(shown.splitlines(), values, strict=True) if not value]
    return "\n".join(line.removeprefix("% ") for line in lines[1:])  # without the title


def _energies(name: str) -> str:
    """What the machine stores, loses and is given: the sum of its parts' four formulas."""
    machine = load_machine(name)
    shown = notation_of(machine).symbols(machine.coordinates, latex=True)
    zero = {symbol: 0 for symbol, value in machine.numbers.items() if value == 0}
    whole = sum(machine.energies, Energies())
    given = sp.Add(*(applied.power for applied in whole.applied_forces))
    formulas = {"T": whole.kinetic, "V": whole.potential, "R": whole.dissipation, "P": given}
    rows = [f"{letter} &= {sp.latex(formula.xreplace(zero).xreplace(shown))}" for letter, formula in formulas.items()]
    return "\n".join([_BEGIN, " \\\\\n".join(rows), _END])
