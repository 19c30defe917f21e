"""The server of `wucht app`: routes, refusals, and verdicts that are those of `wucht run`."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote_to_bytes

import pytest
from tests.conftest import STUDY
from tests.web.built_page import REASON, needs_fastapi, needs_page

from wucht import run_file
from wucht.web.machine_list import machine_list
from wucht.web.session import TOKEN_HEADER, Session
from wucht.web.workers import Workers

if TYPE_CHECKING:
    from starlette.testclient import TestClient

pytestmark = needs_fastapi
PORT = 8417
ORIGIN = f"http://127.0.0.1:{PORT}"
PAGE = {"origin": ORIGIN}
MUST = "must be a study or machine file, or a catalogue name"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Machine files, good and bad ones, and links that lead out."""
    root = tmp_path_factory.mktemp("machines")
    outside = tmp_path_factory.mktemp("outside")
    (outside / "secret.toml").write_text(STUDY, encoding="utf-8")
    (root / "inside").mkdir()
    files = {
        "drum.toml": STUDY, "inside/drum two.toml": STUDY, "bad.toml": "[machine]\nmass = [", "pyproject.toml": "[project]\n",
        "wrong.toml": STUDY.replace('"1 kg"', '"-1 kg"'), "uses.toml": f'[machine]\nuse = "{outside / "secret.toml"}"\n',
        ".hidden.toml": STUDY,
        "long.toml": STUDY.replace("0.5 s", "20000 s"),
    }  # fmt: skip
    for name, text in files.items():
        (root / name).write_text(text, encoding="utf-8")
    (root / "link.toml").symlink_to(outside / "secret.toml")
    (root / "linked").symlink_to(outside)
    return root


@pytest.fixture(scope="module")
def workers(folder: Path) -> Iterator[Workers]:
    """The processes, which are started once; with time enough for the first equations on a busy computer."""
    processes = Workers(folder, judging=120.0)
    yield processes
    processes.close()


def opened(folder: Path, workers: Workers) -> TestClient:
    """The user's browser: it has the cookie of the first page, opened with the first key, and sends the token."""
    from starlette.testclient import TestClient

    from wucht.web.live_server import live_server

    if REASON:
        pytest.skip(REASON)
    session = Session(PORT)
    client = TestClient(live_server(folder, PORT, workers, session), base_url=f"http://127.0.0.1:{PORT}")
    page = client.get("/", params={"key": session.first_key}).text
    client.headers[TOKEN_HEADER] = re.search('data-token="([^"]+)"', page)[1]  # type: ignore[index]
    return client


@contextmanager
def client_with(folder: Path, **limits: float) -> Iterator[TestClient]:
    """A server whose jobs have less time."""
    workers = Workers(folder, **limits)
    yield opened(folder, workers)
    workers.close()


@pytest.fixture(scope="module")
def client(folder: Path, workers: Workers) -> TestClient:
    """The user's browser, after the first page."""
    return opened(folder, workers)


def test_first_page_lists_files_below_the_folder_and_the_catalogue(client: TestClient) -> None:
    page = client.get("/")
    assert page.status_code == 200
    links = re.findall(r'href="/machine/([^"]+)"', page.text)
    assert [x for x in links if x.endswith(".toml")] == [
        "bad.toml",
        "drum.toml",
        "long.toml",
        "uses.toml",
        "wrong.toml",
        "inside/drum%20two.toml",
    ]
    assert "practice/laundry-drum" in links
    assert "sperling-vibration/figure-4" not in links, "its bodies are locked until a release: it cannot be exported"
    assert len(links) > 90


@needs_page
@pytest.mark.parametrize(
    "name",
    [
        "inside/drum%20two.toml",
    ],
)
def test_the_page_of_a_machine_knows_its_server(client: TestClient, name: str) -> None:
    page = client.get(f"/machine/{name}")
    assert page.status_code == 200
    text = json.loads(re.search(r"^const page = (.*);$", page.text, re.M)[1])["text"]  # type: ignore[index]
    assert text["server"] == "/verdict"
    assert text["verdict"] is not None
    assert "connect-src 'self'" in re.search(r'Content-Security-Policy" content="([^"]*)"', page.text)[1]  # type: ignore[index]


@needs_page
@pytest.mark.parametrize("path", ["/machine/drum.toml", "/machine/sperling-vibration/figure-4"])
def test_a_page_runs_its_own_scripts_alone(client: TestClient, path: str) -> None:
    """The policy of the header has the hash of each, and that of the page itself; a page without scripts runs none."""
    answer = client.get(path)
    scripts = re.findall(r"<script[^>]*>(.*?)</script>", answer.text, re.DOTALL)
    hashes = [f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'" for text in scripts]
    policies = [
        answer.headers["content-security-policy"],
        *re.findall(r'Content-Security-Policy" content="([^"]*)"', answer.text),
    ]
    assert len(policies) == 1 + bool(scripts)
    for policy in policies:
        rules = dict(rule.strip().partition(" ")[::2] for rule in policy.split(";"))
        assert rules["default-src"] == "'none'"
        assert rules.get("script-src", "").split() == hashes


@pytest.mark.parametrize(
    ("name", "status", "sentence"),
    [
        ("..%2f..%2f..%2fetc%2fpasswd", 404, "no machine file below"),
        ("link.toml", 404, f"{MUST}|only files below"),
        ("linked%2fsecret.toml", 404, f"{MUST}|only files below"),
        ("nothing.toml", 404, "there is no such file"),
        ("nix", 404, f"FILE: given &#x27;nix&#x27;; {MUST}"),
        ("%22%3E%3Cscript%3E", 404, "&lt;script&gt;"),
        ("wrong.toml", 422, "machine.carrier.mass: given &#x27;-1 kg"),
        ("uses.toml", 404, "only files below"),
        ("sperling-vibration/figure-4", 422, r"machine\.bodies\[1\] \(b1\)\.release: given .*; not allowed in a live machine"),
    ],
)
def test_what_cannot_be_shown_is_refused_by_a_sentence(client: TestClient, name: str, status: int, sentence: str) -> None:
    answer = client.get(f"/machine/{name}")
    assert answer.status_code == status
    assert answer.headers["content-type"].startswith("text/html")
    assert re.search(sentence, answer.text)
    assert "Traceback" not in answer.text
    assert "<script>" not in answer.text


@pytest.mark.skipif(sys.platform != "linux", reason="only there is a name any bytes")
def test_a_name_that_is_not_utf8_is_listed_as_well(tmp_path: Path) -> None:
    """A file of somebody else's in a shared folder must not take the list away."""
    for name in (b"a\xff.toml", "b\u00fc.toml".encode()):
        (tmp_path / os.fsdecode(name)).write_text(STUDY, encoding="utf-8")
    page = machine_list(tmp_path, [])
    assert [unquote_to_bytes(x) for x in re.findall(r'href="/machine/([^"]+)"', page)] == [
        b"a\xff.toml",
        "b\u00fc.toml".encode(),
    ]
    page.encode("utf-8")


@pytest.mark.parametrize("path", ["/docs", "/verdict", "/favicon.ico"])
def test_there_are_no_other_routes(client: TestClient, path: str) -> None:
    assert client.get(path).status_code in (404, 405)


@pytest.mark.parametrize("method", ["PUT", "OPTIONS"])
def test_no_other_method_does_anything(client: TestClient, method: str) -> None:
    assert client.request(method, "/verdict", headers=PAGE).status_code == 405
    assert client.request(method, "/verdict").status_code == 403


@pytest.mark.parametrize(
    "host",
    ["example.org", "127.0.0.1:80", f"127.0.0.1:{PORT}.example.org", ""],
)
def test_another_host_is_refused(client: TestClient, host: str) -> None:
    """A name that leads here without being that of this computer: a page of it would be of the same origin."""
    assert client.get("/", headers={"host": host}).status_code == 403
    assert client.post("/verdict", headers={"host": host, "origin": f"http://{host}"}, content=STUDY).status_code == 403


@pytest.mark.parametrize(
    "origin",
    [None, "null", f"https://127.0.0.1:{PORT}", "http://127.0.0.1:8000", f"{ORIGIN}/"],
)
def test_a_verdict_is_given_to_pages_of_this_server_alone(client: TestClient, origin: str | None) -> None:
    answer = client.post("/verdict", content=STUDY, headers={} if origin is None else {"origin": origin})
    assert answer.status_code == 403
    assert "label" not in answer.text


def test_pages_elsewhere_load_nothing_but_may_link(client: TestClient) -> None:
    loading = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors"}
    assert client.get("/", headers=loading).status_code == 403
    assert client.get("/", headers=loading | {"sec-fetch-site": "same-site"}).status_code == 403
    assert client.get("/", headers=loading | {"sec-fetch-mode": "navigate"}).status_code == 200
    assert client.get("/", headers={"sec-fetch-site": "same-origin", "sec-fetch-mode": "cors"}).status_code == 200


def test_a_study_file_is_at_most_a_megabyte(client: TestClient) -> None:
    from wucht.web.live_server import LARGEST

    answer = client.post("/verdict", content=b"#" * (LARGEST + 1), headers=PAGE)
    assert (answer.status_code, answer.json()) == (413, {"error": "the study file is larger than 1 MB"})
    assert client.post("/verdict", content=b"#" * LARGEST, headers=PAGE).json()["error"].startswith("machine: ")
    parts = iter([b"#" * LARGEST, b"#"])  # sent without its length
    assert client.post("/verdict", content=parts, headers=PAGE).status_code == 413


def verdict_of(client: TestClient, study: str) -> dict[str, Any]:
    answer = client.post("/verdict", content=study, headers=PAGE)
    assert answer.status_code == 200
    result: dict[str, Any] = answer.json()
    return result


@pytest.mark.parametrize(
    ("setting", "until", "label"),
    [('"drive.slope" = 0.04', "0.5 s", "unidentified"), ('"drive.slope" = 0.4', "8 s", "compensated")],
)
def test_a_verdict_is_that_of_wucht_run(client: TestClient, tmp_path: Path, setting: str, until: str, label: str) -> None:
    study = STUDY.replace("[study]", f"[machine.set]\n{setting}\n\n[study]").replace("0.5 s", until)
    (tmp_path / "study.toml").write_text(study, encoding="utf-8")
    result = run_file(tmp_path / "study.toml")
    assert verdict_of(client, study) == {"label": result.wucht.summary["outcome"], "sentence": result.wucht.sentence}
    assert result.wucht.summary["outcome"] == label


@pytest.mark.slow
@needs_page
def test_a_page_whose_verdict_takes_too_long_comes_without_one(folder: Path) -> None:
    with client_with(folder, judging=0.3) as client:
        page = client.get("/machine/long.toml")
    assert page.status_code == 200
    assert json.loads(re.search(r"^const page = (.*);$", page.text, re.M)[1])["text"]["verdict"] is None  # type: ignore[index]


def test_bytes_that_are_no_text_are_refused(client: TestClient) -> None:
    assert client.post("/verdict", content=b"\xff\xfe", headers=PAGE).status_code == 422


def test_files_below_a_folder(folder: Path) -> None:
    from wucht.web.live_server import file_below

    root = folder.resolve()
    assert file_below(root, "inside/drum two.toml") == root / "inside" / "drum two.toml"
    for name in (
        "link.toml",
        "linked/secret.toml",
        "../x.toml",
        "inside/../drum.toml",
        "inside",
        "",
        "drum",
        "\0",
        "c:\\x.toml",
    ):
        assert file_below(root, name) is None


def test_every_answer_lets_a_page_load_nothing_and_ask_only_this_server(client: TestClient) -> None:
    for answer in (client.get("/"), client.get("/nothing"), client.post("/verdict"), client.get("/", headers={"host": "x"})):
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'")
        assert "connect-src 'self'" in policy
        assert "frame-ancestors 'none'" in policy
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert not [name for name in answer.headers if name.startswith("access-control")]
        assert "server" not in answer.headers


def test_this_computer_has_two_names(client: TestClient) -> None:
    name = f"localhost:{PORT}"
    answer = client.post("/verdict", headers={"host": name, "origin": f"http://{name}"}, content="x")
    assert answer.status_code == 200
    assert client.post("/verdict", headers={"host": name, "origin": ORIGIN}, content="x").status_code == 403
