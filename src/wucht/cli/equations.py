"""``wucht equations``: the equations of a machine in readable form."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from wucht.cli.options import Imports, Settings, StudyName
from wucht.errors import InputError

if TYPE_CHECKING:
    from wucht.analysis.equations_in_print import PrintedEquations
    from wucht.machines.machine import Machine


def equations(
    study: StudyName,
    slow: Annotated[bool, typer.Option("--slow", help="The averaged equations, the fast rotation averaged away.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="As LaTeX.")] = False,
    inertia: Annotated[
        bool | None,
        typer.Option("--inertia/--no-inertia", help="With --slow: keep the inertia of the balancing bodies, or not."),
    ] = None,
    order: Annotated[int, typer.Option("--order", help="With --slow: 1, or 2 for the next order.")] = 1,
    set_: Settings = None,
    import_: Imports = None,
) -> None:
    """Print the equations of motion that follow from the machine's energies, or the averaged equations."""
    if order not in (1, 2):
        raise InputError("--order", order, "must be 1 or 2")
    if not slow and (inertia is not None or order != 1):
        raise InputError("--order" if order != 1 else "--inertia", None, "allowed only with --slow")
    from wucht.analysis.equations_in_print import equation_lines, full_equations
    from wucht.cli.options import parse_settings
    from wucht.files.catalogue import load_document, load_machine
    from wucht.machines.symbols import notation_of
    from wucht.results.formatting import units_in_print

    if "system" in load_document(study)[0]:
        if slow:
            raise InputError("--slow", None, "allowed only for a machine: equations of a table [system] are printed as given")
        _print_user_system(study, parse_settings(set_ or []), latex)
        return
    machine = load_machine(study, parse_settings(set_ or []))
    heading, equation_set = _slow_equations(machine, latex, inertia, order) if slow else ("", full_equations(machine, latex))
    rows, definitions = equation_lines(equation_set, latex)
    comment, names = "% " if latex else "", notation_of(machine).names
    typer.echo(f"{comment}{machine.title}")
    for title, lines in ((heading, rows), ("with", definitions)):
        if title and lines:
            typer.echo(f"{comment}{title}")
        if lines:
            _print(lines, latex)
    over_time = {s.parameter for s in machine.schedules}
    for path, p in machine.parameters.items():
        value = f"{names[path]} = {p.value:g} {units_in_print(p.unit)}".rstrip()
        remark = ", at t = 0: it has a schedule" if path in over_time else ", left out" if p.value == 0 else ""
        typer.echo(f"{comment}{value}   {path}: {p.long_name}{remark}")
    for note in machine.notes:
        typer.echo(f"{comment}{units_in_print(note)}")


def _print_user_system(study: str, settings: dict[str, Any], latex: bool) -> None:
    """Print the equations of a table [system]."""
    from sympy import Symbol
    from sympy import latex as in_latex

    from wucht.files.catalogue import load_equations
    from wucht.mechanics.notation import equation_text

    user_system, comment = load_equations(study, settings), "% " if latex else ""
    rates = [Symbol(f"\\dot{{{in_latex(x)}}}" if latex else f"{x}'") for x in user_system.system.states]
    rows = [
        equation_text((left_side, right_side), latex)
        for left_side, right_side in zip(rates, user_system.system.derivatives, strict=True)
    ]
    typer.echo(f"{comment}{user_system.title}")
    _print([*rows, *(equation_text(definition, latex) for definition in user_system.system.definitions)], latex)
    for name, value in user_system.values.items():
        typer.echo(f"{comment}{name} = {value:g}")


def _print(lines: list[str], latex: bool) -> None:
    if latex:
        typer.echo("\\begin{align}")
        typer.echo(" \\\\\n".join(f"  {line}" for line in lines))
        typer.echo("\\end{align}")
    else:
        typer.echo("\n".join(f"  {line}" for line in lines))


def _slow_equations(machine: Machine, latex: bool, inertia: bool | None, order: int) -> tuple[str, PrintedEquations]:
    from wucht.analysis.equations_in_print import slow_equations
    from wucht.machines.operation import has_damped_balancers

    with_inertia = not has_damped_balancers(machine) if inertia is None else inertia
    if not with_inertia and not has_damped_balancers(machine):
        raise InputError("--no-inertia", None, "not allowed here: a balancing body is not damped against its rotor")
    inertia_text = f"{'with' if with_inertia else 'without'} the inertia of the balancing bodies"
    return (
        f"averaged equations of order {order}, {inertia_text}:",
        slow_equations(machine, with_inertia, order, latex),
    )
