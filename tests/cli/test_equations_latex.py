"""``wucht equations --latex`` is typeset: by matplotlib's mathtext, which knows the commands of TeX and refuses others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import pytest

from wucht import load_machine
from wucht.files.catalogue import load_document, names
from wucht.machines.symbols import notation_of
from wucht.mechanics.notation import latex_name

Command = Callable[..., Any]
WITHOUT_AVERAGED = "there are no averaged equations"


def rows(printed: str) -> Iterator[str]:
    """The equations within align, each with all its lines."""
    within, begun = False, ""
    for line in printed.splitlines():
        if line.startswith(("\\begin", "\\end")):
            within = line.startswith("\\begin")
        elif within:
            begun += line.removesuffix("\\\\").strip()
            if not begun.endswith("\\notag"):
                yield begun
                begun = ""
    assert not begun


@cache
def parser() -> Any:
    from matplotlib.mathtext import MathTextParser

    return MathTextParser("path")


def typeset(row: str) -> None:
    """Raises ``ValueError`` for what is no TeX."""
    assert row.count("&=") == 1
    for line in row.split("\\notag"):
        assert line.count("&") <= 1
        parser().parse(f"${line.replace('&', '')}$")


def longest_line(printed: str) -> int:
    return max(len(line) for line in printed.splitlines() if not line.startswith("%"))


def test_the_witness_refuses_what_tex_does() -> None:
    for wrong in (r"\ax_{\mathrm{e1}}", r"\R2", r"x_{a}_{b}", r"\left(x"):
        with pytest.raises(ValueError, match=r"Pars|Unknown|Double|Expected"):
            parser().parse(f"${wrong}$")


@pytest.mark.parametrize(
    ("name", "dots", "expected"),
    [
        ("ax_e1", 0, r"a_{\mathrm{x,e1}}"),
        ("R2_drives.e1", 0, r"R_{\mathrm{2,drives.e1}}"),
        ("lambda_b1", 0, r"\lambda_{\mathrm{b1}}"),
        ("theta_p_1", 1, r"\dot{\theta}_{\mathrm{p\_1}}"),
        ("phi", 2, r"\ddot{\varphi}"),
    ],
)
def test_names(name: str, dots: int, expected: str) -> None:
    assert latex_name(name, dots) == expected
    parser().parse(f"${expected}^{{2}}$")


@pytest.mark.slow
def test_every_symbol_of_the_catalogue_is_typeset() -> None:
    machines = [load_machine(name) for name in names() if "machine" in load_document(name)[0]]
    symbols = {symbol for machine in machines for symbol in notation_of(machine).names.values()}
    assert len(symbols) > 150
    for symbol in symbols:
        parser().parse(f"${latex_name(symbol)}$")


def test_the_torque_of_a_drive_is_a_symbol_with_its_formula_apart(wucht: Command) -> None:
    """As T_e1 of the speed against the stator, which is on the carrier: in its row, in the rotor's, and where it is defined."""
    for how in ((), ("--slow",)):
        printed = list(rows(wucht("equations", "practice/screen", "--latex", *how).out))
        using = [row for row in printed if r"T_{\mathrm{e1}}\left(" in row]
        formula = [row for row in using if row.startswith(r"T_{\mathrm{e1}}\left(\omega\right) &= ")]
        assert len(formula) == 1
        assert len(using) == (2 if how else 3)
        assert next(row for row in printed if r"R_{\mathrm{2,e1}}" in row) == formula[0], "no other row has the motor's circuit"


@pytest.mark.slow
@pytest.mark.parametrize("how", [(), ("--slow",)], ids=["full", "averaged"])
def test_the_catalogue(wucht: Command, how: tuple[str, ...]) -> None:
    done = set[str]()
    for name in names():
        document, _ = load_document(name)
        if "machine" not in document and ("system" not in document or how):
            continue
        printed = wucht("equations", name, "--latex", *how)
        if how and printed.code == 2:
            assert WITHOUT_AVERAGED in printed.err
            continue
        assert printed.code == 0, printed.err
        found = set(rows(printed.out))
        assert found
        assert longest_line(printed.out) <= 300, name
        for row in found - done:
            typeset(row)
        done |= found
    assert len(done) > 50
