"""`wucht app` as a process, and its page in a real browser: the label goes with a change, and comes back from Python."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from tests.conftest import STUDY
from tests.web.built_page import needs_fastapi, needs_page
from tests.web.running_app import running_app

from wucht import run_file

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = needs_fastapi


def children(pid: int) -> list[int]:
    done = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True, check=False)
    return [int(word) for word in done.stdout.split()]


@pytest.mark.slow
@needs_page
@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked at by a program of Linux")
def test_the_command_serves_and_ends_with_ctrl_c(tmp_path: Path) -> None:
    """It prints two lines, listens to this computer alone, gives verdicts, and leaves no process behind; not even in the middle
    of a verdict."""
    (tmp_path / "drum.toml").write_text(STUDY, encoding="utf-8")
    with running_app(tmp_path, "drum.toml") as app:
        process, port = app.process, app.port
        user = app.user_headers()
        assert "const page = " in app.ask("/", user).text
        assert json.loads(app.ask("/verdict", user, STUDY.encode()).text)["label"] == "unidentified"
        listening = Path("/proc/net/tcp").read_text(encoding="ascii"), Path("/proc/net/tcp6").read_text(encoding="ascii")
        assert f"0100007F:{port:04X} 00000000:0000 0A" in listening[0]
        assert f"00000000:{port:04X} 00000000:0000 0A" not in listening[0]
        assert f":{port:04X} 00000000000000000000000000000000:0000 0A" not in listening[1]
        workers = children(process.pid)
        assert len(workers) == 1
        slow = STUDY.replace('"0.5 s"', '"20000 s"').encode()
        headers = {"Host": f"127.0.0.1:{port}", "Origin": app.address.rstrip("/"), "Content-Length": len(slow), **user}
        lines = ["POST /verdict HTTP/1.1", *(f"{name}: {value}" for name, value in headers.items()), "", ""]
        with socket.create_connection(("127.0.0.1", port)) as connection:
            connection.sendall("\r\n".join(lines).encode() + slow)
            time.sleep(1.0)
            begin = time.monotonic()
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=20)
        assert time.monotonic() - begin < 10
        assert (process.returncode, out, err) == (0, "", "")
        for worker in workers:
            with pytest.raises(ProcessLookupError):
                os.kill(worker, 0)


def test_a_port_in_use_is_one_sentence(refused: object) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        refused("app", "--port", port, "--no-browser", says=(f"--port: given {port}; this port cannot be used", "0 for any"))  # type: ignore[operator]


@pytest.mark.parametrize(
    "missing",
    [
        "fastapi",
    ],
)
def test_without_the_extra_it_says_how_to_install_it(refused: object, missing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [n for n in sys.modules if n.partition(".")[0] == missing or n == "wucht.web.live_server"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, missing, None)
    refused("app", "--no-browser", says=("app: this needs the extra: pip install wucht[web]",))  # type: ignore[operator]


@needs_page
@pytest.mark.slow
def test_in_the_browser_the_label_goes_and_comes_back(browser: Browser, tmp_path: Path) -> None:
    """Of a changed run it is that of `wucht run`; a change during the run has none, and says why."""
    changed = run_file("drozdetskaya-2020/r1", {"drive.slope": 0.039}).wucht
    with running_app(tmp_path, "drozdetskaya-2020/r1") as app:
        page = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
        messages, requests = list[str](), list[str]()
        page.on("console", lambda message: messages.append(message.text))
        page.on("pageerror", lambda error: messages.append(str(error)))
        page.on("request", lambda request: requests.append(f"{request.method} {request.url}"))
        page.goto(app.file.as_uri(), timeout=60_000)
        page.wait_for_selector("html[data-courses]", state="attached", timeout=20_000)
        verdict = page.locator(".verdict")
        assert verdict.inner_text().startswith("captured-modulated")
        slope = "input[type=text][aria-label^='slope']"
        page.fill(slope, "0.039")
        page.press(slope, "Enter")
        assert verdict.inner_text().startswith("not judged")
        page.wait_for_selector(".verdict.judged", timeout=20_000)
        assert verdict.inner_text() == f"{changed.summary['outcome']} – {changed.sentence}"
        assert verdict.inner_text().startswith("compensated")
        page.click("text=Reset to the file")
        assert verdict.inner_text().startswith("captured-modulated")
        page.keyboard.press("End")
        page.click("button.switch")
        assert verdict.inner_text().startswith("not judged")
        assert "only study files are judged" in verdict.inner_text()
        page.wait_for_timeout(300)
        assert verdict.inner_text().startswith("not judged")
        assert messages == []
        posts = [f"POST {app.address}key", f"POST {app.address}verdict"]
        assert [one for one in requests if one.startswith("POST")] == posts
        visits = ("GET file:", f"GET {app.address}?key=", "GET blob:")
        assert [one for one in requests if not one.startswith(visits)] == posts
        assert page.url == app.address, "the key is gone from the address, and so from links"
        page.context.close()


@needs_page
def test_a_file_that_is_not_there_is_one_sentence(refused: Callable[..., str]) -> None:
    refused("app", "nothing.toml", "--port", "0", "--no-browser", says=("nothing.toml: there is no such file",))
