"""The live page in Chromium: first picture (asked: 0.5 s), slider to picture (80 ms median, 150 ms at 95 %), memory.

A picture has all curves: those of the preview while the slider moves, those of the fine run 40 ms later where it rests. It is
there when the frame has ended in which they are drawn. The first one: from the start of the navigation, the median of nine
openings in a browser that runs; before it the machine is drawn at its start.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from wucht.web.shared_study import write_page

_MACHINES = ("drozdetskaya-2020/r1", "practice/screen", "practice/laundry-drum")
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
_PREVIEW, _FINE, _OPENINGS = "data-previews", "data-courses", 9
# The times at which the frames end in which the first curves of either kind are drawn.
_FIRST = """window.pictures = {};
new MutationObserver((changes) => {
  for (const { attributeName } of changes) {
    requestAnimationFrame(() => {
      const channel = new MessageChannel();
      channel.port1.onmessage = () => {
        window.pictures[attributeName] ??= performance.now();
        if (attributeName === "data-courses") document.documentElement.setAttribute("data-drawn", "");
      };
      channel.port2.postMessage(0);
    });
  }
}).observe(document, { subtree: true, attributeFilter: ["data-previews", "data-courses"] });"""
# Until the frame in which the new curves are drawn has ended.
_CHANGES = """async ([count, kinds]) => {
  const slider = document.querySelector(".control input[type=range]");
  const root = document.documentElement;
  const times = [];
  for (let k = 0; k < count; k++) {
    const begin = performance.now();
    const drawn = new Promise((done) => {
      const observer = new MutationObserver(() => {
        observer.disconnect();
        requestAnimationFrame(() => {
          const channel = new MessageChannel();
          channel.port1.onmessage = done;
          channel.port2.postMessage(0);
        });
      });
      observer.observe(root, { attributeFilter: kinds });
    });
    slider.value = String(300 + ((37 * k) % 400));
    slider.dispatchEvent(new Event("input"));
    await drawn;
    times.push(performance.now() - begin);
  }
  return times;
}"""


def measure() -> Iterator[tuple[str, str]]:
    from playwright.sync_api import sync_playwright

    executable = next(filter(None, map(shutil.which, _BROWSERS)), None)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        for name in _MACHINES:
            file = write_page(name, Path(folder, "machine.html"), verdict=False)
            yield f"{name}: the page", f"{file.stat().st_size / 1e3:8.0f} kB"
            yield from _of_page(browser, file, name)
        browser.close()


def _opening(browser: Any, file: Path) -> list[float]:
    """The times of the first paint, of the first curves, and of those of the fine run, in ms."""
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.add_init_script(_FIRST)
    page.goto(file.as_uri())
    page.wait_for_selector("html[data-drawn]", state="attached")
    fine, preview, paint = page.evaluate(
        f"[pictures['{_FINE}'], pictures['{_PREVIEW}'], performance.getEntriesByName('first-contentful-paint')[0].startTime]"
    )
    page.close()
    return [paint, fine if preview is None else preview, fine]


def _of_page(browser: Any, file: Path, name: str) -> Iterator[tuple[str, str]]:
    openings = np.array([_opening(browser, file) for _ in range(_OPENINGS + 1)][1:])
    for words, times in zip(("machine drawn", "first picture", "first picture of the fine run"), openings.T, strict=True):
        yield f"{name}: {words}, median", f"{np.median(times):8.0f} ms"
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.goto(file.as_uri())
    page.wait_for_selector(f"html[{_FINE}]", state="attached")
    for kinds, words in (([_PREVIEW, _FINE], "picture"), ([_FINE], "picture of the fine run")):
        times = np.array(page.evaluate(_CHANGES, [100, kinds]))
        yield f"{name}: slider to {words}, median", f"{np.median(times):8.0f} ms"
        yield f"{name}: slider to {words}, 95 %", f"{np.percentile(times, 95):8.0f} ms"
    if name == _MACHINES[0]:
        session = page.context.new_cdp_session(page)
        sizes = []
        for count in (50, 1000):
            page.evaluate(_CHANGES, [count, [_FINE]])
            session.send("HeapProfiler.collectGarbage")
            sizes.append(session.send("Runtime.getHeapUsage")["usedSize"])
        yield f"{name}: memory gained in 1,000 changes", f"{(sizes[1] - sizes[0]) / 1e6:8.2f} MB"
    page.close()
