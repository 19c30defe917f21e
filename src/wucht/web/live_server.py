"""The live machine on the loopback interface: pages of files and of the catalogue, and verdicts on what they show."""

from __future__ import annotations

import asyncio
import re
import signal
import socket
import sys
from collections.abc import Callable
from pathlib import Path, PurePosixPath
from types import FrameType

import uvicorn
from fastapi import FastAPI, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.requests import ClientDisconnect

from wucht.web.local_requests import LocalRequests
from wucht.web.machine_list import LIST, machine_list, sentence_page
from wucht.web.page_policy import stated_policy
from wucht.web.session import Session
from wucht.web.workers import Workers

VERDICT, KEY = "/verdict", "/key"  # the latter as in `first_page.ts`
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
LARGEST = 1_000_000  # bytes of a study file
SENDING_S = 20.0  # in which it must have come
_WAITING = 16  # connections that are not accepted yet: a browser opens six
# FastAPI can report requests to where variables of the environment say; versions that cannot ignore this.
_NO_TELEMETRY = dict.fromkeys(("tracing", "metrics", "logs", "operation_spans", "auto_configure"), False)


def live_server(
    folder: Path,
    port: int,
    workers: Workers,
    session: Session,
    file: str | None = None,
    after_opening: Callable[[], None] = lambda: None,
) -> LocalRequests:
    """Return the application.

    Parameters
    ----------
    folder : Path
        Below which files are shown.
    port : int
        At which it is served: other hosts and origins are refused.
    workers : Workers
    session : Session
    file : str, optional
        A file or catalogue name, whose page is the first one; by default that is the list, which is at ``/machines`` as well.
    after_opening : callable, optional
        Called once the session's first key is used.

    Returns
    -------
    LocalRequests
        An ASGI application.
    """
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None, title="wucht", telemetry=_NO_TELEMETRY)
    root = folder.resolve()

    def shown_page(name: str) -> Response:
        answer = workers.page(name, VERDICT)
        if "page" in answer:
            return HTMLResponse(answer["page"], headers={"content-security-policy": stated_policy(answer["page"])})
        return _refusal(str(answer["error"]), int(answer.get("status", 422)))

    def first_page() -> Response:
        return list_page() if file is None else shown_page(file)

    def list_page() -> Response:
        answer = workers.machines()
        if "names" not in answer:
            return _refusal(str(answer["error"]), 503)
        return HTMLResponse(machine_list(root, answer["names"]))

    def machine_page(name: str) -> Response:
        path = file_below(root, name)
        if path is None and not _is_catalogue_name(name):
            return _refusal(f"{name}: this is no machine file below {root}, and no name of the catalogue", 404)
        return shown_page(name if path is None else str(path))

    async def verdict(request: Request) -> Response:
        try:
            text = await _study_text(request)
        except ClientDisconnect:  # nobody reads an answer
            return Response(status_code=400)
        except _RefusedError as error:
            return JSONResponse({"error": error.sentence}, error.status)
        answer = await run_in_threadpool(workers.verdict, text)
        return JSONResponse({key: answer[key] for key in ("label", "sentence", "error", "superseded") if key in answer})

    async def key() -> Response:
        return PlainTextResponse(session.new_key())

    app.add_api_route("/", first_page)
    app.add_api_route(LIST, list_page)
    app.add_api_route("/machine/{name:path}", machine_page)
    app.add_api_route(VERDICT, verdict, methods=["POST"])
    app.add_api_route(KEY, key, methods=["POST"])
    return LocalRequests(app, port, session, after_opening)


class _RefusedError(Exception):
    """A study file that is not read: a sentence, and the status of the answer."""

    def __init__(self, sentence: str, status: int) -> None:
        super().__init__(sentence)
        self.sentence, self.status = sentence, status


async def _study_text(request: Request) -> str:
    """The study file that a page sends. Raises ``_RefusedError``, and ``ClientDisconnect`` for one that ends too early."""
    too_large = _RefusedError(f"the study file is larger than {LARGEST // 1_000_000} MB", 413)
    if int(request.headers.get("content-length", "0")) > LARGEST:
        raise too_large
    body = bytearray()
    try:
        async with asyncio.timeout(SENDING_S):
            async for chunk in request.stream():
                body += chunk
                if len(body) > LARGEST:
                    raise too_large
    except TimeoutError:
        raise _RefusedError(f"the study file has not come within {SENDING_S:g} s", 408) from None
    except asyncio.CancelledError:  # the task of the request ends with this answer
        raise _RefusedError("the server is being stopped", 503) from None
    try:
        return body.decode("utf-8")
    except UnicodeDecodeError:
        raise _RefusedError("the study file is not UTF-8 text", 422) from None


class _Server(uvicorn.Server):  # type: ignore[misc]
    """A server that ends the jobs when a signal stops it; so does that of a terminal which is closed."""

    def __init__(self, config: uvicorn.Config, stop: Callable[[], None]) -> None:
        super().__init__(config)
        self._stop = stop
        if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) == signal.SIG_DFL:  # it is ignored after `nohup`
            signal.signal(signal.SIGHUP, self.handle_exit)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """End the jobs, whose requests the server would wait for."""
        self._stop()
        super().handle_exit(sig, frame)


def serve(application: LocalRequests, connection: socket.socket, stop: Callable[[], None]) -> None:
    """Serve an application until Ctrl-C.

    Parameters
    ----------
    application : LocalRequests
    connection : socket
        On which the server listens.
    stop : callable
        Called when a signal ends the server.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C, once all connections are closed.
    """
    # What strangers send is no warning. asyncio prints as many errors as may wait where no connection can be opened any longer.
    config = uvicorn.Config(
        application, log_level="error", access_log=False, lifespan="off", ws="none", server_header=False,
        proxy_headers=False, timeout_graceful_shutdown=1, backlog=_WAITING,
    )  # fmt: skip
    _Server(config, stop).run(sockets=[connection])


def file_below(root: Path, name: str) -> Path | None:
    """Return the machine file of a name relative to a folder; None where there is none, or it lies elsewhere.

    Parameters
    ----------
    root : Path
        The folder, without links.
    name : str
        With ``/`` between folders.

    Returns
    -------
    Path or None
    """
    parts = PurePosixPath(name)
    if "\0" in name or "\\" in name or parts.is_absolute() or ".." in parts.parts:
        return None
    try:
        path = (root / parts).resolve()
        return path if path.is_relative_to(root) and path.suffix == ".toml" and path.is_file() else None
    except (OSError, RuntimeError, ValueError):  # names too long for a file, links in a circle
        return None


def _is_catalogue_name(name: str) -> bool:
    """True where a name can be one of the catalogue; whether it is one, the process knows that reads it."""
    return all(_NAME.fullmatch(part) for part in name.split("/"))


def _refusal(sentence: str, status: int) -> Response:
    return HTMLResponse(sentence_page(sentence), status)
