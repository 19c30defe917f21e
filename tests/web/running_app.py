"""`wucht app` as a process, and a visitor who has what it gives to the user."""

from __future__ import annotations

import http.client
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

_FIRST_LINE = r"^Serving .+ at (http://127\.0\.0\.1:\d+/) \(this computer only\)\. Press Ctrl-C to stop\.$"
_SECOND_LINE = r"^(?:To see it|If no page opens), open this address, which is good once: (file://\S+)$"


@dataclass(frozen=True)
class RunningApp:
    """address: where it listens; file: that opens it; process: of the command."""

    address: str
    file: Path
    process: subprocess.Popen[str]

    @property
    def port(self) -> int:
        """The port at which it listens."""
        return urlsplit(self.address).port or 0

    @property
    def key(self) -> str:
        """The first key, in the file."""
        return re.search(r"key=([\w-]+)", self.file.read_text(encoding="utf-8"))[1]  # type: ignore[index]

    def ask(self, path: str, headers: Mapping[str, str] | None = None, post: bytes | None = None) -> Answer:
        """Send a request that comes from this computer, and return the answer."""
        return asked(self.port, path, headers, post)

    def user_headers(self) -> dict[str, str]:
        """What the user's pages send, once the first page was opened."""
        first = self.ask(f"/?key={self.key}")
        token = re.search('data-token="([^"]+)"', first.text)[1]  # type: ignore[index]
        return {"cookie": first.headers["set-cookie"].partition(";")[0], "x-wucht-token": token}


@dataclass(frozen=True)
class Answer:
    """Of a server."""

    status: int
    headers: Mapping[str, str]
    text: str


def asked(port: int, path: str, headers: Mapping[str, str] | None = None, post: bytes | None = None) -> Answer:
    """Send a request to a port of this computer, as its own pages do."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    own = {"origin": f"http://127.0.0.1:{port}"} if post is not None else {}
    connection.request("GET" if post is None else "POST", path, post, own | dict(headers or {}))
    response = connection.getresponse()
    answer = Answer(
        response.status, {k.lower(): v for k, v in response.getheaders()}, response.read().decode("utf-8", "replace")
    )
    connection.close()
    return answer


@contextmanager
def running_app(
    folder: Path, *words: str, port: int = 0, browser: str = "--no-browser", environment: Mapping[str, str] | None = None
) -> Iterator[RunningApp]:
    """The command in a folder, until the end of the test."""
    command = [sys.executable, "-m", "wucht", "app", *words, "--port", str(port), browser]
    process = subprocess.Popen(command, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
    try:
        assert process.stdout is not None
        lines = [process.stdout.readline(), process.stdout.readline()]
        address, file = (re.search(p, line) for p, line in zip((_FIRST_LINE, _SECOND_LINE), lines, strict=True))
        if address is None or file is None:
            raise AssertionError("".join(lines) + process.communicate(timeout=20)[1])
        yield RunningApp(address[1], Path(url2pathname(urlsplit(file[1]).path)), process)
    finally:
        process.kill()
        process.communicate()
