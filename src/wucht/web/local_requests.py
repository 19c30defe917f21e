"""A gate before an application on the loopback interface: it refuses requests of other hosts, and those of other pages."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

from wucht.web.page_policy import page_policy

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Message, Receive, Send], Awaitable[None]]

# No page of another address frames these, sends forms here, or reads what is answered; nothing of them is stored or told.
_HEADERS = {
    "content-security-policy": f"{page_policy(asks_server=True)}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff", "referrer-policy": "no-referrer", "cache-control": "no-store",
    "cross-origin-resource-policy": "same-origin", "cross-origin-opener-policy": "same-origin",
}  # fmt: skip


class LocalRequests:
    """An ASGI application that lets only requests of this computer's own pages through.

    The name of the host must be that of the loopback interface: under any other name, which a server of names could let point
    here, a page elsewhere would be of the same origin. What changes or computes something (all but GET and HEAD) must come from
    a page that was served here.

    Parameters
    ----------
    application : ASGI application
    port : int
        At which it is served.
    """

    def __init__(self, application: Application, port: int) -> None:
        self._application = application
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request. See the ASGI specification."""
        if scope["type"] != "http":
            return
        reason = self._reason_against(scope)
        if reason is None:
            await self._application(scope, receive, _with_headers(send))
            return
        body, answer = reason.encode(), _with_headers(send)
        headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", str(len(body)).encode())]
        await answer({"type": "http.response.start", "status": 403, "headers": headers})
        await answer({"type": "http.response.body", "body": body})

    def _reason_against(self, scope: Message) -> str | None:
        headers: dict[bytes, list[str]] = {}
        for name, value in scope["headers"]:
            headers.setdefault(name.lower(), []).append(value.decode("latin-1"))
        hosts, origins = headers.get(b"host", []), headers.get(b"origin", [])
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            return "this server answers on 127.0.0.1 and localhost alone"
        if scope["method"] not in ("GET", "HEAD") and origins != [f"http://{hosts[0].lower()}"]:
            return "this request does not come from a page of this server"
        is_visit = headers.get(b"sec-fetch-mode") == ["navigate"]
        if headers.get(b"sec-fetch-site", ["none"]) not in (["none"], ["same-origin"]) and not is_visit:
            return "pages of other servers cannot load this"
        return None


def _with_headers(send: Send) -> Send:
    """Send answers with the headers of all of them."""

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = [(name.encode(), value.encode()) for name, value in _HEADERS.items()]
            message["headers"] = [*message.get("headers", []), *headers]
        await send(message)

    return send_with_headers
