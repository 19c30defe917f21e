"""Equations as they are printed: with the drives' torques and long factors apart they are the same equations."""

from __future__ import annotations

import random
from collections import defaultdict
from collections.abc import Mapping, Sequence

import pytest
import sympy as sp

from wucht.analysis.equations_in_print import DriveTorque, full_equations, zero_parameters
from wucht.files.catalogue import load_document, load_machine, names
from wucht.machines.machine import Machine
from wucht.machines.symbols import notation_of
from wucht.mechanics.lagrange import equations_of_motion
from wucht.mechanics.notation import LONGEST_LINE, Equation, latex_name, printed_equations, short_terms
from wucht.piecewise import PiecewiseCubic


def numbers_of(expressions: Sequence[sp.Expr]) -> dict[sp.Symbol, sp.Float]:
    """A number for each symbol, the same for the same name."""
    symbols = set().union(*(e.free_symbols for e in expressions))
    return {s: sp.Float(random.Random(str(s)).uniform(0.3, 0.9)) for s in symbols}


def value(expression: sp.Expr, definitions: Mapping[sp.Expr, sp.Expr], numbers: Mapping[sp.Symbol, sp.Float]) -> float:
    """The value of an expression whose symbols are defined by others, or have numbers."""
    while True:
        torques = {
            t: next(
                r.xreplace({sp.Symbol("omega"): t.args[1]}) for left, r in definitions.items() if left.args[:1] == t.args[:1]
            )
            for t in expression.atoms(DriveTorque)
        }
        known = {s: definitions[s] for s in expression.free_symbols if s in definitions}
        if not torques and not known:
            return float(expression.xreplace(numbers).xreplace({}).evalf())
        expression = expression.xreplace(torques).xreplace(known)


def plain(machine: Machine) -> list[Equation]:
    """The equations of motion with the formulas of the drives in them."""
    motion = equations_of_motion(machine.energies, machine.coordinates)
    return printed_equations(
        motion, machine.coordinates, notation_of(machine), zero_parameters(machine), latex=False, normalise=False
    )


@pytest.mark.parametrize("name", ["practice/screen", "practice/fan-on-inverter"])
def test_with_the_formula_of_its_drive_each_equation_is_that_of_the_machine(name: str) -> None:
    machine = load_machine(name)
    (equations, torques), whole = full_equations(machine, latex=False), plain(machine)
    definitions = dict(torques)
    numbers = numbers_of([side for e in (*whole, *definitions.items()) for side in e])
    assert any(right.has(DriveTorque) for _, right in equations)
    assert not any(side.has(DriveTorque) for e in whole for side in e)
    for (left, right), (left_whole, right_whole) in zip(equations[: len(whole)], whole, strict=True):
        assert left == left_whole
        assert value(right, definitions, numbers) == pytest.approx(value(right_whole, {}, numbers), rel=1e-12, abs=1e-12)


def test_short_terms_are_the_same_equations() -> None:
    """In numbers; and no term is longer than a line."""
    machine = load_machine("practice/fan-on-belt")
    long, definitions = full_equations(machine, latex=True)
    equations = [*long, *definitions]
    shortened, factors = short_terms(equations)
    definitions = dict(factors)
    assert definitions
    assert any(len(sp.latex(t)) > LONGEST_LINE for e in equations for side in e for t in sp.Add.make_args(side))
    numbers = numbers_of([side for e in equations for side in e])
    torque = {t: sp.Symbol("torque") for e in equations for t in e[0].atoms(DriveTorque) | e[1].atoms(DriveTorque)}
    numbers[sp.Symbol("torque")] = sp.Float(0.4)
    for one, other in zip(equations, shortened, strict=True):
        for side, short in zip(one, other, strict=True):
            expected = value(side.xreplace(torque), {}, numbers)
            assert value(short.xreplace(torque), definitions, numbers) == pytest.approx(expected, rel=1e-12)
            assert all(len(sp.latex(t)) <= LONGEST_LINE for t in sp.Add.make_args(short))


def test_a_step_has_no_slope_in_print() -> None:
    """The derivative of a contact is zero on both sides of its jump: it is not printed."""
    for equation in full_equations(load_machine("practice/grinder-2-balls"), latex=False)[0]:
        assert not any(f.args[1].name.endswith("'") for side in equation for f in side.atoms(PiecewiseCubic))


def machines() -> dict[str, Machine]:
    """One machine of each kind in the catalogue, by the parameters that it has."""
    loaded = (load_machine(name) for name in names() if "machine" in load_document(name)[0])
    return {repr(sorted(m.parameters)): m for m in loaded}


def test_no_symbol_means_two_things_in_a_machine_of_the_catalogue() -> None:
    """Neither the whole symbol, as it is typeset, nor its letter with its index: U is no unbalance beside a voltage U."""
    seen = machines()
    assert len(seen) > 20
    for machine in seen.values():
        notation, meanings = notation_of(machine), defaultdict[str, set[str]](set)
        for path, name in notation.names.items():
            meanings[latex_name(name)].add(path)
        for drive in machine.drives:
            meanings[latex_name(f"T_{drive.path.rpartition('.')[2]}")].add(f"torque of {drive.path}")
        meanings[latex_name("omega")].add("speed, the argument of a torque")
        assert {s: m for s, m in meanings.items() if len(m) > 1} == {}, machine.title
        units = defaultdict[str, set[str]](set)
        for p in machine.parameters.values():
            units[p.symbol.removesuffix("_x").removesuffix("_y")].add(p.unit)
        assert {s: u for s, u in units.items() if len(u) > 1} == {}, machine.title
