"""The commands put together, and the one place where errors become sentences and exit codes."""

from __future__ import annotations

import sys

import typer

import wucht
from wucht.errors import InputError, WuchtError

app = typer.Typer(
    name="wucht",
    help="Machines in which rotation and vibration act on each other: from a machine file to a verdict.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"wucht {wucht.__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Show the version and exit."),
) -> None:
    """Machines in which rotation and vibration act on each other: from a machine file to a verdict."""


def _register() -> None:
    from wucht.cli.equations import equations
    from wucht.cli.list import list_all
    from wucht.cli.new import new
    from wucht.cli.plot import plot
    from wucht.cli.run import run

    app.command("run")(run)
    app.command("list")(list_all)
    app.command("new")(new)
    app.command("equations")(equations)
    app.command("plot")(plot)


def run_app() -> None:
    """Run the command line. Exit codes: 0 done, 1 a run failed, 2 the input is wrong, 130 interrupted."""
    _register()
    try:
        app()
    except InputError as error:
        sys.stderr.write(f"wucht: {error}\n")
        sys.exit(2)
    except WuchtError as error:
        sys.stderr.write(f"wucht: {error}\n")
        sys.exit(1)
    except KeyboardInterrupt:
        sys.stderr.write("wucht: interrupted\n")
        sys.exit(130)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
