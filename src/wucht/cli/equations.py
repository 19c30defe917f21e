"""``wucht equations``: the machine's equations, readable."""

from __future__ import annotations

from typing import Annotated

import typer

from wucht.errors import InputError


def equations(
    study: Annotated[str, typer.Argument(help="A study file, or a name from `wucht list`.")],
    slow: Annotated[bool, typer.Option("--slow", help="The slow equations (not yet).")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="As LaTeX.")] = False,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter; repeatable.")] = None,
) -> None:
    """Print the equations of motion that follow from the machine's energies."""
    if slow:
        raise InputError("--slow", None, "not yet: the slow equations come with a later version")
    from wucht.cli.settings import parse_settings
    from wucht.machines.catalogue import load_machine
    from wucht.machines.notation import notation_of
    from wucht.mechanics.lagrange import equations_of_motion
    from wucht.mechanics.notation import written

    machine = load_machine(study, parse_settings(set_ or []))
    notation = notation_of(machine)
    motion = equations_of_motion(machine.energies, machine.coordinates)
    zero = [s for s, value in machine.numbers.items() if value == 0]
    lines = written(motion, machine.coordinates, notation, zero, latex, normalise=not machine.units.time)
    comment = "% " if latex else ""
    typer.echo(f"{comment}{machine.title}")
    if latex:
        typer.echo("\\begin{align}")
        typer.echo(" \\\\\n".join(f"  {line.replace(' = ', ' &= ', 1)}" for line in lines))
        typer.echo("\\end{align}")
    else:
        typer.echo("\n".join(f"  {line}" for line in lines))
    for path, p in machine.parameters.items():
        typer.echo(
            f"{comment}{notation.names[path]} = {p.value:g} {p.unit}".rstrip()
            + f"   {path}: {p.what}"
            + (", left out" if not p.value else "")
        )
