"""The commands as one application, and the one place where errors become sentences and exit codes."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import nullcontext, suppress
from functools import wraps
from typing import Any, cast

import typer
from typer.completion import completion_init  # type: ignore[attr-defined]

import wucht
from wucht.cli.surroundings import check_environment, fit_address_space, without_dask
from wucht.environment import set_threads
from wucht.errors import InputError, WuchtError
from wucht.file_names import printable

# Typer brings its own click, so its base class of usage errors is reached through a subclass that Typer exports.
_USAGE_ERROR = cast(type[Exception], typer.BadParameter.__base__)
_WITH_LIBRARIES = (
    "run",
    "answer",
    "compare",
    "plot",
    "export",
    "report",
    "share",
)  # of numbers: the other commands do not load them

app = typer.Typer(
    name="wucht",
    help="Machines in which rotation and vibration act on each other: from a machine file to a verdict.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(is_requested: bool) -> None:
    if is_requested:
        typer.echo(f"wucht {wucht.__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Show the version and exit."),
) -> None:
    """Machines in which rotation and vibration act on each other: from a machine file to a verdict."""


def register() -> None:
    """Give the app its commands."""
    from wucht.cli.answer import answer
    from wucht.cli.compare import compare
    from wucht.cli.completion import completion
    from wucht.cli.equations import equations
    from wucht.cli.export import export
    from wucht.cli.list import list_all
    from wucht.cli.live_app import live_app
    from wucht.cli.new import new
    from wucht.cli.plot import plot
    from wucht.cli.report import report
    from wucht.cli.run import run
    from wucht.cli.share import share

    app.registered_commands.clear()
    commands: dict[str, Callable[..., None]] = {
        "run": run, "answer": answer, "compare": compare, "list": list_all, "new": new, "equations": equations, "plot": plot,
        "export": export, "report": report, "share": share, "app": live_app, "completion": completion,
    }  # fmt: skip
    for name, command in commands.items():
        app.command(name)(_with_exit_errors(command, loads_libraries=name in _WITH_LIBRARIES))
    completion_init()  # registers the shells; Typer does so itself only with its own options for completion


class _NobodyReadsError(Exception):
    """The reader of the output has left, as ``head`` does."""


def _with_exit_errors(command: Callable[..., None], *, loads_libraries: bool) -> Callable[..., None]:
    """Wrap a command so that Ctrl-C becomes Typer's Abort: a plain KeyboardInterrupt would end it without a message.

    Click would end it likewise, with exit code 1, where the reader of the output has left.
    """

    @wraps(command)
    def guarded_command(*arguments: Any, **options: Any) -> None:
        try:
            if loads_libraries:
                set_threads()
                fit_address_space()
            with without_dask() if loads_libraries and options.get("scheduler") is None else nullcontext():
                command(*arguments, **options)
        except KeyboardInterrupt as error:
            raise typer.Abort(str(error)) from None
        except BrokenPipeError:
            raise _NobodyReadsError from None

    return guarded_command


def run_app() -> int:
    """Run the command line; its exit code: 0 done, 1 a run failed, 2 the input is wrong, 130 interrupted."""
    register()
    try:
        check_environment()
        code = app(standalone_mode=False)
        sys.stdout.flush()  # while a failure can still be reported
    except InputError as error:
        code = _print_error(str(error), 2, file=error.file, key=error.key, given=error.value_text, allowed=error.explanation)
    except WuchtError as error:
        code = _print_error(str(error), 1)
    except (KeyboardInterrupt, typer.Abort) as error:
        code = _print_error(str(error) or "interrupted", 130)
    except (_NobodyReadsError, BrokenPipeError):
        code = 0
    except SystemExit as error:  # raised by Typer where the reader of its help text has left
        if not isinstance(error.__context__, BrokenPipeError):
            raise
        code = 0
    except OSError as error:  # errors of files are reported where they occur: this is the output
        code = _print_error(f"the output cannot be written: {error.strerror or error}", 1)
    except _USAGE_ERROR as error:
        sentence = error.format_message() if isinstance(error, typer.BadParameter) else getattr(error, "message", str(error))
        code = _print_error(f"{' '.join(sentence.split())} See wucht -h", 2)
    return code or 0


def _print_error(sentence: str, code: int, **place: str) -> int:
    """Print an error to stderr; with ``--json`` also as an object to stdout, for the next program of a pipe."""
    with suppress(OSError):  # no space there either: the exit code still tells of the error
        if "--json" in sys.argv[1:]:
            location = {name: place.get(name) or None for name in ("file", "key", "given", "allowed")}
            sys.stdout.write(
                json.dumps({"error": sentence} | location | {"exit_code": code}, indent=2, ensure_ascii=False) + "\n"
            )
        sys.stderr.write(f"wucht: {printable(sentence)}\n")
    return code
