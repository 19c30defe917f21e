"""A report as a browser prints it: pages of A4 with all their text. Debian has the browser as package ``chromium``."""

from __future__ import annotations

import re
import shutil
import subprocess
import zlib
from pathlib import Path

import pytest

import wucht
from wucht.reports.html_report import write_report

_BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_BROWSER = next((path for name in _BROWSERS if (path := shutil.which(name))), None)
_A4 = (595.0, 842.0)  # points
_TRAP = "<script>document.title='run'</script>"

pytestmark = pytest.mark.skipif(_BROWSER is None, reason=f"none of {', '.join(_BROWSERS)} is installed (Debian: chromium)")


def _print(page: Path, folder: Path) -> bytes:
    """The PDF that the browser makes of a page."""
    target = folder / "printed.pdf"
    command = [
        str(_BROWSER), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}",
        "--no-pdf-header-footer", f"--print-to-pdf={target}", page.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert target.is_file(), done.stderr
    return target.read_bytes()


def _objects(pdf: bytes) -> bytes:
    """The PDF with its compressed streams opened, in which some versions keep the pages."""
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    opened = []
    for stream in streams:
        try:
            opened.append(zlib.decompress(stream))
        except zlib.error:
            continue
    return b"\n".join([pdf, *opened])


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes]:
    """The folder and the PDF of a report of two results."""
    folder = tmp_path_factory.mktemp("chromium")
    wucht.run_file("practice/grinder-4-balls", {"study.until": 0.3}, folder=folder / "grinder")
    wucht.run_file("practice/screen", {"study.kind": "torque-balance"}, folder=folder / "screen")
    page = write_report([folder / "grinder", folder / "screen"], folder / "report.html", f"For a customer {_TRAP} 振動")
    return folder, _print(page, folder)


def test_pages_are_a4_and_none_is_wasted(printed: tuple[Path, bytes]) -> None:
    content = _objects(printed[1])
    boxes = re.findall(rb"/MediaBox\s*\[\s*0\s+0\s+([\d.]+)\s+([\d.]+)\s*\]", content)
    pages = len(re.findall(rb"/Type\s*/Page\b(?!s)", content))
    assert 5 <= pages <= 12  # contents, and two to five pages a chapter
    assert boxes
    for box in boxes:
        assert tuple(map(float, box)) == pytest.approx(_A4, abs=1.0)


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="pdftotext is not installed (Debian: poppler-utils)")
def test_all_text_is_there_as_text(printed: tuple[Path, bytes]) -> None:
    folder, _ = printed
    pdf = str(folder / "printed.pdf")
    text = subprocess.run(["pdftotext", "-layout", pdf, "-"], capture_output=True, text=True, check=True).stdout
    pages = text.split("\f")[:-1]
    assert _TRAP in " ".join(text.split())
    count = len(pages)
    for k, page in enumerate(pages, 1):
        assert re.search(rf"\b{k}\s*/\s*{count}\b", page), "the number at the foot of the page"
        assert len(page.split()) > 20, "a page that is nearly empty"
    for words in ("Angle grinder with a worn wheel", "2 working points, 1 of them stable", "mount 1", "110 N/mm", "[study]"):
        assert words in text
    assert "speed (rad/s)" in text, "names of scales are text"
    screen = next(k for k, page in enumerate(pages) if "Study torque-balance" in page)
    assert pages[screen].lstrip().startswith("Vibratory screen"), "a chapter begins on a page"


_TEN = (
    {"study.kind": "run-up", "study.until": 10.0}, {"study.kind": "synchronous-states"}, {"study.kind": "torque-balance"},
    {"study.kind": "response"}, {"study.kind": "drive-failure"}, {"study.kind": "start-stop"},
    {"study.kind": "voltage-dip", "study.depth": 1.0}, {"study.kind": "coast-down"}, {"study.kind": "load-spectrum"},
    {"study.kind": "run-up", "e2.unbalance": 0.5},
)  # fmt: skip


@pytest.mark.slow
def test_ten_results_of_one_machine_are_at_most_15_pages(tmp_path: Path) -> None:
    places = [tmp_path / str(k) for k in range(len(_TEN))]
    for place, question in zip(places, _TEN, strict=True):
        wucht.run_file("practice/screen", question, folder=place)
    content = _objects(_print(write_report(places, tmp_path / "report.html"), tmp_path))
    assert 8 <= len(re.findall(rb"/Type\s*/Page\b(?!s)", content)) <= 15
