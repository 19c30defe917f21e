"""Equations of a machine as they are printed: the torque of a drive is one symbol, T(omega), and its formula a line apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp
from sympy.core.symbol import Str

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.machines.parts.base import Drive
from wucht.machines.symbols import notation_of
from wucht.mechanics.energies import AppliedForce, Energies
from wucht.mechanics.lagrange import equations_of_motion
from wucht.mechanics.notation import (
    Equation,
    equation_text,
    latex_name,
    printed_averaged_equations,
    printed_equations,
    printed_state_rates,
    short_terms,
)

SPEED = sp.Symbol("omega", real=True)  # the argument of a drive's formula


class DriveTorque(sp.Function):  # type: ignore[misc]
    """``DriveTorque(name, speed, *states)``: the torque of a drive as one symbol; with a prime in its name, its slope."""

    def _eval_derivative(self, symbol: sp.Symbol) -> sp.Expr:
        name, speed, *states = self.args
        return sp.diff(speed, symbol) * self.func(Str(f"{name}'"), speed, *states)

    def _eval_is_real(self) -> bool:
        return True

    def _sympystr(self, printer: sp.printing.StrPrinter) -> str:
        name, *arguments = self.args
        return f"{name}({', '.join(map(printer._print, arguments))})"

    def _latex(self, printer: sp.printing.latex.LatexPrinter, exp: str | None = None) -> str:
        name, primes = str(self.args[0]).rstrip("'"), str(self.args[0]).count("'") * "'"
        arguments = ", ".join(map(printer._print, self.args[1:]))
        latex = f"{latex_name(name)}{primes}\\left({arguments}\\right)"
        return latex if exp is None else f"{{{latex}}}^{{{exp}}}"


PrintedEquations = tuple[list[Equation], list[Equation]]  # equations, and the definitions that they use, in printed symbols


def equation_lines(equation_set: PrintedEquations, latex: bool) -> tuple[list[str], list[str]]:
    """Return both as lines; in LaTeX an equation of several lines is one text."""
    equations, definitions = equation_set
    if latex:
        short, factors = short_terms([*equations, *definitions])
        equations, definitions = short[: len(equations)], [*short[len(equations) :], *factors]
    return [equation_text(e, latex) for e in equations], [equation_text(e, latex) for e in definitions]


def full_equations(machine: Machine, latex: bool) -> PrintedEquations:
    """Return the equations of motion with the rates of internal states, and the torques of the drives.

    Parameters
    ----------
    machine : Machine
    latex : bool
        In symbols of LaTeX, or as plain text.

    Returns
    -------
    PrintedEquations
    """
    notation, zero = notation_of(machine), zero_parameters(machine)
    apart, torques = _with_torques_apart(machine)
    motion = equations_of_motion(apart.energies, apart.coordinates)
    rows = printed_equations(motion, apart.coordinates, notation, zero, latex, normalise=not machine.units.time)
    rates = printed_state_rates(apart.internal, apart.coordinates, notation, latex)
    return [*rows, *rates], _printed_torques(machine, torques, latex)


def slow_equations(machine: Machine, inertia: bool, order: int, latex: bool) -> PrintedEquations:
    """Return the averaged equations with their definitions, and the torques of the drives.

    Parameters
    ----------
    machine : Machine
    inertia : bool
        Keep the inertia of the balancing bodies.
    order : int
        1 or 2.
    latex : bool
        In symbols of LaTeX, or as plain text.

    Returns
    -------
    PrintedEquations

    Raises
    ------
    InputError
        Where the machine has no averaged equations.
    """
    apart, torques = _with_torques_apart(machine)
    senses = {r.name: int(sense_of(machine, r)) for r in machine.rotors}
    system = averaged_equations_of(apart, inertia, order, turning=senses).averaged_system
    rows, definitions = printed_averaged_equations(system, notation_of(machine), zero_parameters(machine), latex)
    return rows, [*definitions, *_printed_torques(machine, torques, latex)]


def zero_parameters(machine: Machine) -> list[sp.Symbol]:
    """Return the parameters that are 0 and remain so: terms with them are not printed."""
    over_time = {s.symbol for s in machine.schedules}
    return [s for s, value in machine.numbers.items() if value == 0 and s not in over_time]


def _with_torques_apart(machine: Machine) -> tuple[Machine, list[tuple[DriveTorque, sp.Expr]]]:
    """The machine with a ``DriveTorque`` for each torque that depends on the speed; these over SPEED, with their formulas."""
    drives, torques = {d.path: d for d in machine.drives}, list[tuple[DriveTorque, sp.Expr]]()
    energies = list[Energies]()
    for e in machine.energies:
        motor = next((a for a in e.applied_forces if a.name in drives), None)
        if motor is None or not motor.force.free_symbols & motor.rate.free_symbols:
            energies.append(e)
            continue
        states = [s.state for s in e.internal_states]
        torque = DriveTorque(Str(f"T_{motor.name.rpartition('.')[2]}"), motor.rate, *states)
        # A transmission's loss acts at the same rate: the symbol is the torque that arrives at the body.
        whole = sp.Add(*(a.force for a in e.applied_forces))
        torques.append((torque.func(torque.args[0], SPEED, *states), _torque_of_speed(whole, motor.rate, drives[motor.name])))
        internal = tuple(replace(s, rate=s.rate.xreplace({motor.force: torque})) for s in e.internal_states)
        energies.append(replace(e, applied_forces=(AppliedForce(torque, motor.rate, motor.name),), internal_states=internal))
    return machine.with_fields(energies=tuple(energies)), torques


def _torque_of_speed(torque: sp.Expr, rate: sp.Expr, drive: Drive) -> sp.Expr:
    """A torque in terms of SPEED, the speed of the body against the stator."""
    body = sp.Symbol(f"{drive.on}.speed", real=True)
    return torque.xreplace({body: SPEED - (rate - body)})


def _printed_torques(machine: Machine, torques: Sequence[tuple[DriveTorque, sp.Expr]], latex: bool) -> list[Equation]:
    nothing = dict.fromkeys(zero_parameters(machine), sp.S.Zero)
    symbols = notation_of(machine).symbols(machine.coordinates, latex)
    symbols[SPEED] = sp.Symbol(latex_name("omega") if latex else "omega")
    return [(left.xreplace(symbols), right.xreplace(nothing).xreplace(symbols)) for left, right in torques]
