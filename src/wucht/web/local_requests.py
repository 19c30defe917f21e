"""A gate before an application on the loopback interface: it lets only the pages of the user who started it through."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from typing import Any
from urllib.parse import parse_qs

from starlette.responses import HTMLResponse, PlainTextResponse

from wucht.web.first_page import STRANGER, first_page, first_page_policy
from wucht.web.page_policy import page_policy
from wucht.web.session import TOKEN_HEADER, Session

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Message, Receive, Send], Awaitable[None]]

# No page of another address frames these, sends forms here, or reads what is answered; nothing of them is stored or told.
_NO_FRAMES = "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
_HEADERS = {
    "x-content-type-options": "nosniff", "referrer-policy": "no-referrer", "cache-control": "no-store",
    "cross-origin-resource-policy": "same-origin", "cross-origin-opener-policy": "same-origin",
}  # fmt: skip
_POLICY = "content-security-policy"


class LocalRequests:
    """An ASGI application that lets only requests of this computer's own pages through, opened by the user who started it.

    The name of the host must be that of the loopback interface: under any other name, which a server of names could let point
    here, a page elsewhere would be of the same origin. What changes or computes something (all but GET and HEAD) must come from
    a page that was served here. Other accounts of the computer, whose programs can send any header, lack the session's secrets:
    a request must bear its cookie, and its token or the key that a page got for it. Any other visit gets the first page.

    Parameters
    ----------
    application : ASGI application
    port : int
        At which it is served.
    session : Session
    after_opening : callable, optional
        Called once the session's first key is used.
    """

    def __init__(
        self, application: Application, port: int, session: Session, after_opening: Callable[[], None] = lambda: None
    ) -> None:
        self._application, self._session, self._after_opening = application, session, after_opening
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request. See the ASGI specification."""
        if scope["type"] != "http":
            return
        headers = _headers(scope)
        if reason := self._reason_against(scope, headers):
            answer: Application = PlainTextResponse(reason, 403)
        elif self._is_of_session(scope, headers):
            answer = self._application
        elif scope["method"] not in ("GET", "HEAD"):
            answer = PlainTextResponse(STRANGER, 403)
        elif scope["method"] == "GET" and self._session.begins_with(_key(scope)):
            self._after_opening()
            answer = _first_page(200, self._session.token, {"set-cookie": self._session.set_cookie})
        else:
            answer = _first_page(200 if self._session.has_cookie(headers.get("cookie", [])) else 403)
        await answer(scope, receive, _with_headers(send))

    def _is_of_session(self, scope: Message, headers: dict[str, list[str]]) -> bool:
        """Whether a request bears the cookie, and the token or a key."""
        if not self._session.has_cookie(headers.get("cookie", [])):
            return False
        return self._session.has_token(headers.get(TOKEN_HEADER, [])) or (
            scope["method"] == "GET" and self._session.opens_with(_key(scope))
        )

    def _reason_against(self, scope: Message, headers: dict[str, list[str]]) -> str:
        """Why a request does not come from a page of this computer; empty where it may."""
        hosts, origins = headers.get("host", []), headers.get("origin", [])
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            return "this server answers on 127.0.0.1 and localhost alone"
        if scope["method"] not in ("GET", "HEAD") and origins != [f"http://{hosts[0].lower()}"]:
            return "this request does not come from a page of this server"
        is_visit = headers.get("sec-fetch-mode") == ["navigate"]
        if headers.get("sec-fetch-site", ["none"]) not in (["none"], ["same-origin"]) and not is_visit:
            return "pages of other servers cannot load this"
        return ""


def _headers(scope: Message) -> dict[str, list[str]]:
    """The headers of a request by name, in lower case; one may come several times."""
    headers: dict[str, list[str]] = {}
    for name, value in scope["headers"]:
        headers.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))
    return headers


def _key(scope: Message) -> str:
    """The key in the address of a request; empty where there is none."""
    keys: list[str] = parse_qs(scope["query_string"].decode("latin-1")).get("key", [""])
    return keys[0]


def _first_page(status: int, token: str = "", headers: Mapping[str, str] = {}) -> Application:
    return HTMLResponse(first_page(token), status, {_POLICY: first_page_policy(), **headers})


def _with_headers(send: Send) -> Send:
    """Send answers with the headers of all of them. A page with scripts states its own policy, which is kept."""

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = {name.decode(): value.decode("latin-1") for name, value in message.get("headers", [])}
            policy = headers.get(_POLICY, page_policy(asks_server=True))
            headers |= _HEADERS | {_POLICY: f"{policy}; {_NO_FRAMES}"}
            message["headers"] = [(name.encode(), value.encode("latin-1")) for name, value in headers.items()]
        await send(message)

    return send_with_headers
