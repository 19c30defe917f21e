"""Pictures of the live machine for the README and pages, taken in a browser: ``python -m docs.site.live_pictures``.

It needs Chromium and the package ``playwright``. Like those of ``docs.site.pictures`` they are drawn files in the repository.
"""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from wucht.web.shared_study import write_page

from .gallery import ROOT

FOLDER = ROOT / "docs" / "pictures"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
_MILLISECONDS, _QUALITY = 110, 48  # of a frame of the moving picture, of its compression
_DRAWN = "html[data-courses]"


@dataclass(frozen=True)
class Screen:
    """What is on the screen. file: of the catalogue. shares: of the run, at which frames are taken."""

    file: str
    width: int
    height: int
    shares: tuple[float, ...]
    scheme: str = "light"
    is_stroboscopic: bool = False


SCREENS = {
    "live-machine": Screen(
        "practice/laundry-drum", 1280, 720, (*(0.0025 * k**1.6 for k in range(40)), 1.0), is_stroboscopic=True
    ),
    "live-machine-dark": Screen("drozdetskaya-2020/r1", 1280, 720, (0.7,), scheme="dark"),
    "live-machine-phone": Screen("practice/screen", 390, 844, (0.3,)),
}


def main() -> None:
    """Take all pictures."""
    from playwright.sync_api import sync_playwright

    executable = next(filter(None, map(shutil.which, BROWSERS)), None)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        for name, screen in SCREENS.items():
            page = write_page(screen.file, Path(folder) / f"{name}.html")
            _save(_frames(browser, page, screen), FOLDER / f"{name}.webp")
        browser.close()


def _frames(browser: Any, page_file: Path, screen: Screen) -> list[bytes]:
    """Screenshots of a page at the shares of its run, as PNG."""
    size = {"width": screen.width, "height": screen.height}
    page = browser.new_page(viewport=size, color_scheme=screen.scheme)
    page.goto(page_file.as_uri())
    page.wait_for_selector(_DRAWN, state="attached")
    if screen.is_stroboscopic:
        page.get_by_label("rotate the view with the rotor").check()
    frames = []
    for share in screen.shares:
        page.get_by_label("time", exact=True).evaluate(
            "(slider, share) => { slider.value = share * slider.max; slider.dispatchEvent(new Event('input')) }", share
        )
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        frames.append(page.screenshot())
    page.close()
    return frames


def _save(frames: list[bytes], file: Path) -> None:
    """Save a picture, or a moving one of several frames, the last of which stays for a while."""
    from PIL import Image

    first, *later = [Image.open(BytesIO(frame)).convert("RGB") for frame in frames]
    if not later:
        first.save(file, quality=_QUALITY + 30, method=6)
        return
    durations = [_MILLISECONDS] * len(later) + [3000]
    first.save(
        file, save_all=True, append_images=later, duration=durations, loop=0, quality=_QUALITY, method=6, minimize_size=True
    )


if __name__ == "__main__":
    main()
