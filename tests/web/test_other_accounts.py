"""What other accounts of the computer get from `wucht app`: nothing, whatever their programs and their pages do."""

from __future__ import annotations

import http.cookiejar
import json
import os
import re
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from tests.conftest import STUDY
from tests.node import run_in_node
from tests.web.built_page import needs_fastapi, needs_page
from tests.web.running_app import RunningApp, asked, running_app

import wucht

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [needs_page, needs_fastapi]
NOBODY = 65534
SECRET = "A machine that is nobody's business"
TITLED = STUDY.replace("A drum with two pendulums", SECRET)
PATHS = ("/", "/machines", "/machine/private.toml", "/machine/practice/laundry-drum", "/key", "/verdict")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of the user's, and a browser that waits."""
    folder = tmp_path_factory.mktemp("private", numbered=False)
    (folder / "private.toml").write_text(TITLED, encoding="utf-8")
    folder.chmod(0o700)
    (folder / "private.toml").chmod(0o600)
    return folder


@pytest.fixture(scope="module")
def app(folder: Path) -> Iterator[RunningApp]:
    with running_app(folder, "private.toml") as running:
        yield running


@pytest.fixture(scope="module")
def user(app: RunningApp) -> dict[str, str]:
    """Headers of the user's pages."""
    headers = app.user_headers()
    assert SECRET in app.ask("/", headers).text
    return headers


def of_another_account(script: str, *words: str) -> Any:
    """What a program of another account prints as JSON."""
    if sys.platform == "win32" or os.getuid() != 0:
        pytest.skip("only root can run a program as another account")
    begin = (
        f"import encodings.idna, glob, http.client, json, os, sys\nos.setgroups([]); os.setgid({NOBODY}); os.setuid({NOBODY})\n"
    )
    command = [sys.executable, "-c", begin + script, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_another_account_gets_the_first_page_without_data(app: RunningApp, user: dict[str, str]) -> None:
    """Whatever headers its program sends: those of a browser's visit, those of a page, wrong secrets."""
    script = """
answers, port = [], int(sys.argv[1])
own = {"origin": f"http://127.0.0.1:{port}", "sec-fetch-site": "same-origin"}
visit = own | {"sec-fetch-site": "none", "sec-fetch-mode": "navigate"}
wrong = own | {"cookie": f"wucht-{port}=; wucht-{port}=x", "x-wucht-token": "x"}
for method in ("GET", "POST", "HEAD", "OPTIONS"):
    for path in json.loads(sys.argv[2]):
        for headers in ({}, own, visit, wrong):
            connection = http.client.HTTPConnection("127.0.0.1", port)
            connection.request(method, path, sys.argv[3] if method == "POST" else None, headers)
            answer = connection.getresponse()
            answers.append([answer.status, repr(answer.getheaders()) + answer.read().decode()])
print(json.dumps(answers))
"""
    paths = [*PATHS, "/?key=", "/?key=x", "/machine/private.toml?key=" + "x" * 43]
    answers = of_another_account(script, str(app.port), json.dumps(paths), STUDY)
    assert {status for status, _ in answers} == {403}
    for _, text in answers:
        for word in (SECRET, "private", "laundry", "label", "set-cookie", *user.values(), user["cookie"].partition("=")[2]):
            assert word not in text


def test_what_another_account_can_see_of_processes_holds_no_secret(folder: Path, tmp_path: Path) -> None:
    """Arguments and environments of all processes, that of the browser too; the file that opens it is not readable."""
    browser, opened, end = tmp_path / "browser", tmp_path / "opened", tmp_path / "end"
    browser.write_text(
        f'#!/bin/sh\necho "$@" > {opened}.part\nmv {opened}.part {opened}\nwhile [ ! -e {end} ]; do sleep 0.1; done\n',
        encoding="ascii",
    )
    browser.chmod(0o700)
    script = """
seen = []
for path in glob.glob("/proc/[0-9]*/*"):
    if path.rpartition("/")[2] in ("cmdline", "environ"):
        try:
            seen.append(open(path, "rb").read().decode("latin-1"))
        except OSError as error:
            seen.append(type(error).__name__)
try:
    seen.append(open(sys.argv[1]).read())
except OSError as error:
    seen.append(f"file: {type(error).__name__}")
print(json.dumps(seen))
"""
    environment = os.environ | {"BROWSER": f"{browser} %s"}
    with running_app(folder, "private.toml", browser="--browser", environment=environment) as app:
        deadline = time.monotonic() + 20
        while not opened.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        try:
            assert opened.read_text(encoding="ascii").strip() == app.file.as_uri()
            assert stat.S_IMODE(app.file.stat().st_mode) == 0o600
            key = app.key
            seen = of_another_account(script, str(app.file))
            user = app.user_headers()
            seen += of_another_account(script, str(app.file))
        finally:
            end.touch()
    assert any("wucht\0app\0private.toml" in text for text in seen), "the arguments of the server are among them"
    assert any(str(opened.parent / "browser") in text for text in seen), "and those of the browser"
    assert "file: PermissionError" in seen
    assert "file: FileNotFoundError" in seen, "it is removed once it was used"
    for secret in (key, user["cookie"].partition("=")[2], user["x-wucht-token"]):
        assert len(secret) == 43
        assert not [text for text in seen if secret in text]


def test_the_first_key_is_good_once(app: RunningApp, user: dict[str, str]) -> None:
    """What it gave is needed in full: with the cookie alone there is the first page, with the token alone nothing."""
    cookie, token = ({name: user[name]} for name in ("cookie", "x-wucht-token"))
    assert not app.file.exists()
    for path in PATHS[:4]:
        reload = app.ask(path, cookie)
        assert (reload.status, "set-cookie" in reload.headers) == (200, False)
        assert 'data-token=""' in reload.text
        assert SECRET not in reload.text
        assert app.ask(path, token).status == 403
    for headers in (cookie, token, {}, cookie | {"x-wucht-token": f"{user['x-wucht-token']}x"}):
        assert app.ask("/key", headers, b"").status == 403
        assert app.ask("/verdict", headers, STUDY.encode()).status == 403


def test_a_key_of_a_page_is_good_once_and_for_the_browser_alone(app: RunningApp, user: dict[str, str]) -> None:
    cookie = {"cookie": user["cookie"]}
    key = app.ask("/key", user, b"").text
    assert SECRET not in app.ask(f"/machine/private.toml?key={key}").text
    assert SECRET in app.ask(f"/machine/private.toml?key={key}", cookie).text
    assert SECRET not in app.ask(f"/machine/private.toml?key={key}", cookie).text


def test_a_cookie_of_another_port_with_this_name_locks_nobody_out(app: RunningApp, user: dict[str, str]) -> None:
    """A server at another port can set it, also for a longer path, which a browser sends first."""
    name = user["cookie"].partition("=")[0]
    assert SECRET in app.ask("/", user | {"cookie": f"{name}=x; {user['cookie']}; {name}=y"}).text
    assert name == f"wucht-{app.port}"


class Collector(BaseHTTPRequestHandler):
    """A server of another account, which keeps the cookies that it is sent."""

    cookies: list[str]
    page = b"a page"

    def do_GET(self) -> None:
        """Answer a visit."""
        self.cookies.append(self.headers.get("cookie", ""))
        self.send_response(200)
        self.send_header("content-type", "text/html")
        self.send_header("content-length", str(len(self.page)))
        self.end_headers()
        self.wfile.write(self.page)

    def log_message(self, *words: object) -> None:
        """Say nothing."""


@contextmanager
def collecting(page: str, port: int = 0) -> Iterator[tuple[int, list[str]]]:
    """Such a server, its port and its cookies."""
    cookies: list[str] = []
    server = ThreadingHTTPServer(
        ("127.0.0.1", port), type("Handler", (Collector,), {"cookies": cookies, "page": page.encode()})
    )
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield server.server_port, cookies
    finally:
        server.shutdown()
        server.server_close()


def test_a_server_at_another_port_gets_the_cookie_which_is_not_enough(folder: Path) -> None:
    """The standard library's cookies belong to no port, either."""
    jar = http.cookiejar.CookieJar()
    browser = urllib.request.build_opener(urllib.request.ProxyHandler({}), urllib.request.HTTPCookieProcessor(jar))
    with running_app(folder, "private.toml") as app, collecting("a page") as (port, cookies):
        browser.open(f"{app.address}?key={app.key}")
        browser.open(f"http://127.0.0.1:{port}/")
        stolen = {"cookie": cookies[-1]}
        assert re.fullmatch(rf"wucht-{app.port}=[\w-]{{43}}", cookies[-1])
        answers = [app.ask(path, stolen) for path in PATHS]
        answers += [app.ask(path, stolen | {"sec-fetch-site": "none"}, STUDY.encode()) for path in PATHS]
        assert [answer.status for answer in answers] == [200] * len(PATHS) + [403] * len(PATHS)
        for answer in answers:
            assert not re.search(rf'{SECRET}|private|laundry|label|data-token="\w', answer.text)


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such signals")
@pytest.mark.parametrize(
    "number", [pytest.param("SIGINT", marks=pytest.mark.slow), "SIGTERM", pytest.param("SIGHUP", marks=pytest.mark.slow)]
)
def test_at_the_end_the_file_is_removed_though_nobody_used_it(folder: Path, number: str) -> None:
    if signal.getsignal(getattr(signal, number)) is signal.SIG_IGN:
        pytest.skip("the tests run where this signal is ignored, as after `nohup`, and so does the server")
    with running_app(folder, "private.toml") as app:
        assert app.ask("/").status == 403
        assert app.file.exists()
        app.process.send_signal(getattr(signal, number))
        out, err = app.process.communicate(timeout=20)
    assert (out, err) == ("", "")
    assert not app.file.exists()


def test_what_was_given_is_worth_nothing_at_the_next_start(folder: Path) -> None:
    """At the same port, which another account may have had in between: it got the cookie there, and what pages keep."""
    with running_app(folder, "private.toml") as app:
        key, user = app.key, app.user_headers()
        page_key = app.ask("/key", user, b"").text
        app.process.terminate()
        app.process.wait(20)
    with collecting("a page", app.port) as (port, cookies):
        asked(port, "/", user)
        assert cookies == [user["cookie"]]
    with running_app(folder, "private.toml", port=app.port) as again:
        new_user = again.user_headers()
        assert SECRET in again.ask("/", new_user).text
        assert again.ask(f"/?key={key}").status == 403
        assert again.ask(f"/?key={page_key}", user).status == 403
        for path in PATHS:
            assert again.ask(path, user).status == 403
            assert again.ask(path, user, STUDY.encode()).status == 403
        assert again.ask("/", user | {"cookie": new_user["cookie"]}).status == 200
        assert SECRET not in again.ask("/", user | {"cookie": new_user["cookie"]}).text
        assert SECRET not in again.ask("/", new_user | {"cookie": user["cookie"]}).text


def unfinished(port: int, lines: Sequence[str]) -> None:
    """Send a part of a request, and leave."""
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.sendall("\r\n".join(lines).encode())
        time.sleep(0.1)


@pytest.mark.slow
def test_unfinished_posts_end_without_a_word(folder: Path) -> None:
    """Those of the user's pages, and those of others; one that is still open does not hold up the end."""
    with running_app(folder, "private.toml") as app:
        user = [f"{name}: {value}" for name, value in app.user_headers().items()]
        own = ["POST /verdict HTTP/1.1", f"Host: 127.0.0.1:{app.port}", f"Origin: {app.address.rstrip('/')}"]
        for headers in (user, []):
            for length in ("Content-Length: 1000", "Transfer-Encoding: chunked"):
                unfinished(app.port, [*own, *headers, length, "", "5"])
        with socket.create_connection(("127.0.0.1", app.port)) as connection:
            connection.sendall("\r\n".join([*own, *user, "Content-Length: 1000", "", "[machine]"]).encode())
            time.sleep(0.3)
            begin = time.monotonic()
            app.process.send_signal(signal.SIGTERM if sys.platform == "win32" else signal.SIGINT)
            err = app.process.communicate(timeout=20)[1]
        assert time.monotonic() - begin < 10
    assert "Traceback" not in err
    assert len(err.splitlines()) <= 1, err


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of another process can be set on Linux alone")
def test_what_strangers_send_neither_fills_the_log_nor_ends_the_server(folder: Path) -> None:
    """What is no request, and more connections than the process may have."""
    import resource

    with running_app(folder, "private.toml") as app:
        unfinished(app.port, ["GET", "", ""])
        unfinished(
            app.port, ["GET / HTTP/1.1", f"Host: 127.0.0.1:{app.port}", "Connection: Upgrade", "Upgrade: websocket", "", ""]
        )
        resource.prlimit(app.process.pid, resource.RLIMIT_NOFILE, (50, 50))
        connections = [socket.socket() for _ in range(60)]
        for connection in connections:
            connection.setblocking(False)
            connection.connect_ex(("127.0.0.1", app.port))
        time.sleep(1.5)
        for connection in connections:
            connection.close()
        assert app.ask("/").status == 403
        app.process.terminate()
        err = app.process.communicate(timeout=20)[1]
    assert "Too many open files" in err
    assert len(err) < 40_000
    assert "Invalid HTTP" not in err
    assert "uvicorn" not in err


@pytest.mark.slow
def test_a_post_that_does_not_end_is_answered_all_the_same(app: RunningApp, user: dict[str, str]) -> None:
    from wucht.web.live_server import SENDING_S

    headers = [f"{name}: {value}" for name, value in user.items()]
    own = ["POST /verdict HTTP/1.1", f"Host: 127.0.0.1:{app.port}", f"Origin: {app.address.rstrip('/')}"]
    with socket.create_connection(("127.0.0.1", app.port), timeout=SENDING_S + 10) as connection:
        connection.sendall("\r\n".join([*own, *headers, "Content-Length: 1000", "", "[machine]"]).encode())
        begin = time.monotonic()
        assert connection.recv(1000).startswith(b"HTTP/1.1 408 ")
    assert time.monotonic() - begin == pytest.approx(SENDING_S, abs=2.0)


@pytest.mark.parametrize("key", ["a." * 20_000 + "a", '"a" . ' * 10_000 + "a"], ids=["words", "texts"])
def test_a_key_of_thousands_of_parts_is_refused_at_once(app: RunningApp, user: dict[str, str], key: str) -> None:
    """Its parts make as many tables; the reader of TOML takes the square of their number: 10 s for the first."""
    app.ask("/verdict", user, STUDY.encode())  # the process has begun
    for text in (f"{key} = 1\n", f"[{key}]\n", f"x = {{ {key} = 1 }}\n"):
        begin = time.monotonic()
        answer = json.loads(app.ask("/verdict", user, text.encode()).text)
        assert time.monotonic() - begin < 0.5
        part = key.partition(".")[0].strip()
        assert answer["error"].endswith(f": {part}: at most 40 tables and lists may be nested (at line 1)")


FIRST_PAGE = """
const [module, address] = process.argv.slice(1);
const led = [];
globalThis.location = Object.assign(new URL(address), { replace: (to) => led.push(new URL(to, address).href) });
globalThis.document = { documentElement: { dataset: {} }, body: {} };
globalThis.localStorage = { getItem: () => "token" };
globalThis.fetch = async () => ({ ok: true, text: async () => "KEY" });
await import(module);
await new Promise((done) => setTimeout(done, 10));
console.log(JSON.stringify(led));
"""


@pytest.mark.parametrize("path", ["/machine/private.toml", "//127.0.0.1:9/steal", "/\\127.0.0.1:9/steal", "///a@b/", "//"])
def test_the_key_of_a_page_is_led_to_this_server_alone(path: str) -> None:
    """Whatever the path of a link from elsewhere: as an address, `//HOST/` is another server's, which has the cookie."""
    module = Path(wucht.__file__).parent / "web" / "first_page.ts"
    for query, fragment in (("", ""), ("?key=old", "#%7B%7D")):
        led = json.loads(
            run_in_node(
                "--input-type=module", "-e", FIRST_PAGE, module.as_uri(), f"http://127.0.0.1:8417{path}{query}{fragment}"
            )
        )
        assert led == [f"http://127.0.0.1:8417{path.replace(chr(92), '/')}?key=KEY{fragment}"]


@pytest.mark.slow
def test_pages_of_another_port_get_nothing_in_a_browser(browser: Browser, folder: Path) -> None:
    """They fetch, post, frame, open, lead and collect; the user's own page works, is reloaded, and opens in a second tab."""
    attack = """<body><script>
      const address = "APP"; const got = {};
      const attempt = async (name, action) => { try { got[name] = await action(); } catch (error) { got[name] = "refused"; } };
      const post = (headers, mode) => fetch(address + "verdict",
        { method: "POST", body: "x", headers, mode, credentials: "include" });
      const framed = () => new Promise((done) => {
        const frame = document.createElement("iframe"); frame.src = address + "machine/private.toml";
        frame.onload = () => { try { done(frame.contentDocument.body.textContent); } catch (error) { done("refused"); } };
        document.body.append(frame);
      });
      const opened = async () => {
        const other = open(address + "machine/private.toml");
        await new Promise((done) => setTimeout(done, 3000));
        try { return other.document.body.textContent; } catch (error) { return other.closed ? "closed" : "refused"; }
      };
      (async () => {
        await attempt("read", async () => (await fetch(address, { credentials: "include" })).text());
        await attempt("unread", async () => (await fetch(address, { mode: "no-cors", credentials: "include" })).text());
        await attempt("post", async () => (await post({}, "cors")).text());
        await attempt("token", async () => (await post({ "x-wucht-token": "x" }, "cors")).text());
        await attempt("script", () => new Promise((done, fail) => {
          const script = document.createElement("script"); script.src = address; script.onload = () => done("loaded");
          script.onerror = fail; document.body.append(script); }));
        await attempt("frame", framed);
        await attempt("open", opened);
        document.title = "done";
        document.documentElement.dataset.got = JSON.stringify(got);
      })();
    </script></body>"""
    with running_app(folder, "private.toml") as app:
        context = browser.new_context()
        page = context.new_page()
        page.goto(app.file.as_uri())
        page.wait_for_selector("html[data-courses]", state="attached", timeout=60_000)
        assert page.inner_text("h1") == SECRET
        page.reload()
        page.wait_for_selector("html[data-courses]", state="attached", timeout=60_000)
        tab = context.new_page()
        tab.goto(f"{app.address}machines")
        tab.click("text=private.toml")
        tab.wait_for_selector("html[data-courses]", state="attached", timeout=60_000)
        with collecting(attack.replace("APP", app.address)) as (port, cookies):
            other = context.new_page()
            other.goto(f"http://127.0.0.1:{port}/")
            other.wait_for_function("document.title === 'done'", timeout=30_000)
            got = json.loads(other.get_attribute("html", "data-got") or "")
            assert f"wucht-{app.port}=" in cookies[0], "the browser sends it to every port"
            visits = len(cookies)
            names = ("read", "unread", "post", "token", "script", "frame")
            assert {name: got.pop(name) for name in names} == dict.fromkeys(names, "refused")
            assert got["open"] in ("refused", "closed")
            leading = context.new_page()
            leading.goto(f"{app.address}/127.0.0.1:{port}/")
            leading.wait_for_url("**?key=*")
            assert leading.url.startswith(app.address)
            assert len(cookies) == visits, "the page's key does not come here"
            stolen = {"cookie": cookies[0]}
            assert app.ask("/", stolen).status == 200
            assert SECRET not in app.ask("/machine/private.toml", stolen).text
            assert app.ask("/verdict", stolen, STUDY.encode()).status == 403
        stranger = browser.new_context().new_page()
        stranger.goto(app.address)
        stranger.wait_for_selector("text=belongs to the user who started wucht app")
        app.process.terminate()
        app.process.wait(20)
        with collecting("taken over", app.port) as (port, cookies):
            page.goto(app.address)
            kept = {"cookie": cookies[0], "x-wucht-token": page.evaluate("localStorage.getItem('wucht-token')")}
            assert len(kept["x-wucht-token"]) == 43, "the page that took the port over reads what pages keep"
    with running_app(folder, "private.toml", port=app.port) as again:
        page.goto(again.address)
        page.wait_for_selector("text=belongs to the user who started wucht app")
        assert again.ask("/", kept).status == again.ask("/verdict", kept, STUDY.encode()).status == 403
        page.goto(again.file.as_uri())
        page.wait_for_selector("html[data-courses]", state="attached", timeout=60_000)
        context.close()
