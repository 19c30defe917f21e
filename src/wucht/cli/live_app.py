"""``wucht app``: the live machine, served on the loopback interface, with verdicts on what it shows."""

from __future__ import annotations

import socket
import sys
import threading
import webbrowser
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wucht.cli.completing import study_names
from wucht.errors import InputError, RunError

if TYPE_CHECKING:
    from wucht.web.workers import Workers

# Any that is free: at a port known before, a server of another account could have left a script in the user's browser
# (a service worker), which would get the first page.
DEFAULT_PORT = 0
_HOST, _LARGEST_PORT = "127.0.0.1", 65535


def live_app(
    study: Annotated[
        str | None,
        typer.Argument(
            metavar="[FILE]", autocompletion=study_names, help="A study or machine file, or a name from `wucht list`."
        ),
    ] = None,
    port: Annotated[int, typer.Option("--port", help="The port, 0 to 65535; 0: any free one.")] = DEFAULT_PORT,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser, or not.")] = True,
) -> None:
    """Show machines in the browser: they move, and wucht judges what is shown. Served to this computer only."""
    try:
        from wucht.web.live_server import live_server, serve
    except ModuleNotFoundError as error:
        if error.name not in ("fastapi", "uvicorn"):
            raise
        raise InputError("app", None, "this needs the extra: pip install wucht[web]", code="no-extra") from None
    from wucht.web.opening_file import OpeningFile
    from wucht.web.session import Session
    from wucht.web.workers import Workers

    folder, name = _place(study)
    with _bound_socket(port) as connection, ExitStack() as at_the_end:
        workers = Workers(folder)
        at_the_end.callback(workers.close)
        _check(workers, name)
        bound_port = connection.getsockname()[1]
        session = Session(bound_port)
        address = f"http://{_HOST}:{bound_port}/"
        first_address = f"{address}?key={session.first_key}"
        opening_file = OpeningFile(first_address)
        at_the_end.callback(opening_file.remove)
        typer.echo(
            f"Serving {study or f'the machines below {folder}'} at {address} (this computer only). Press Ctrl-C to stop."
        )
        # Another account may be able to read what is printed to a file, but not what is printed to the terminal.
        typer.echo(f"{'If no page opens' if browser else 'To see it'}, open this address, which is good once: ", nl=False)
        typer.echo(first_address if sys.stdout.isatty() else opening_file.path.as_uri())
        sys.stdout.flush()
        if browser:
            threading.Thread(target=webbrowser.open, args=(opening_file.path.as_uri(),), daemon=True).start()
        application = live_server(folder, bound_port, workers, session, name, opening_file.remove)
        with suppress(KeyboardInterrupt):
            serve(application, connection, at_the_end.close)


def _place(study: str | None) -> tuple[Path, str | None]:
    """The folder below which files are shown: the present one, or that of a file elsewhere; and the file or catalogue name."""
    here = Path.cwd().resolve()
    if study is None or not Path(study).is_file():
        return here, study
    path = Path(study).resolve()
    return here if path.is_relative_to(here) else path.parent, str(path)


def _bound_socket(port: int) -> socket.socket:
    """A socket of the loopback interface. Raises ``InputError`` if there is no such port, or it cannot be used."""
    if not 0 <= port <= _LARGEST_PORT:
        raise InputError("--port", port, f"must be 0 to {_LARGEST_PORT}", code="port")
    connection = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if sys.platform != "win32":  # there, another program could take the port away
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        connection.bind((_HOST, port))
        connection.listen()
    except OSError as error:
        connection.close()
        reason = f"this port cannot be used ({error.strerror or error}); give another one, or 0 for any that is free"
        raise InputError("--port", port, reason, code="port") from None
    return connection


def _check(workers: Workers, name: str | None) -> None:
    """Raises ``InputError`` for a file that no page can show, ``RunError`` if the page was not built."""
    answer = workers.check(name)
    if "location" in answer:
        raise InputError(answer["location"], None, answer["explanation"])
    if "error" in answer:
        raise RunError(str(answer["error"]))
