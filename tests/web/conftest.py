"""A real browser: Chromium of the system or of Playwright, in which every request to another place is blocked and recorded."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from wucht.errors import WuchtError
from wucht.web.live_page import built_file
from wucht.web.shared_study import shared_page

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """The browser, if there is one."""
    try:
        built_file("live.js")
    except WuchtError as error:
        pytest.skip(str(error))
    from playwright.sync_api import Error, sync_playwright

    executable = next(filter(None, map(shutil.which, NAMES)), None)
    with sync_playwright() as playwright:
        try:
            chromium = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        except Error:
            pytest.skip("no Chromium is installed: `.venv/bin/playwright install chromium-headless-shell` installs one")
        yield chromium
        chromium.close()


@dataclass
class OpenPage:
    """A page in the browser, what it said on the console, and where it asked for something."""

    page: Page
    messages: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def courses(self) -> int:
        """How many fine courses were drawn; previews are not counted."""
        return int(self.page.get_attribute("html", "data-courses") or 0)

    def wait_for_course(self, before: int) -> None:
        """Wait until another fine course is drawn."""
        self.page.wait_for_selector(f"html[data-courses]:not([data-courses='{before}'])", state="attached", timeout=20_000)
        self.page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def pixels(self, selector: str) -> str:
        """What a canvas shows."""
        return str(self.page.eval_on_selector(selector, "(canvas) => canvas.toDataURL()"))


class Browsing:
    """Opens pages of machines, each made once."""

    def __init__(self, browser: Browser, folder: Path) -> None:
        self._browser, self._folder = browser, folder
        self._open: list[OpenPage] = []

    def file(self, name: str, **settings: Any) -> Path:
        """The page of a machine of the catalogue."""
        path = self._folder / f"{name.replace('/', '-')}.html"
        if not path.exists():
            path.write_text(shared_page(name, settings), encoding="utf-8")
        return path

    def open(self, path: Path, link: str = "", script: str = "", **context: Any) -> OpenPage:
        """Open a file, and wait for its first course. script: runs before the page's."""
        options = {"viewport": {"width": 1280, "height": 720}} | context
        page = self._browser.new_context(**options).new_page()
        shown = OpenPage(page)
        self._open.append(shown)
        page.on("console", lambda message: shown.messages.append(message.text))
        page.on("pageerror", lambda error: shown.messages.append(str(error)))
        page.route("**/*", lambda route: route.continue_() if route.request.url.startswith("file:") else route.abort())
        page.on("request", lambda request: shown.requests.append(request.url))
        page.add_init_script(script)
        page.goto(path.as_uri() + link)
        page.wait_for_selector("html[data-courses]", state="attached", timeout=20_000)
        return shown

    def check(self) -> None:
        """No page said anything on the console, or asked for anything but itself."""
        for shown in self._open:
            assert shown.messages == []
            assert [url[:60] for url in shown.requests if not url.startswith(("file:", "blob:"))] == []
            shown.page.context.close()


@pytest.fixture(scope="session")
def folder_of_pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pages")


@pytest.fixture
def browsing(browser: Browser, folder_of_pages: Path) -> Iterator[Browsing]:
    """Pages in a browser; at the end, none has misbehaved."""
    session = Browsing(browser, folder_of_pages)
    yield session
    session.check()
