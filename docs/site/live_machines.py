"""Live machines in pages: at ``<!-- live: FILE | CAPTION -->``, and one for each file of the catalogue that can be shared.

FILE is a name of the catalogue, or a file that the page itself has (a block of TOML with a title). Pages are kept beside what
the gallery keeps, as long as the file and all code are the same.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from wucht.errors import WuchtError
from wucht.files.catalogue import load_document, names
from wucht.web.live_page import built_file
from wucht.web.shared_study import shared_page

from . import gallery
from .page_figures import write_files

MARK = re.compile(r"^<!-- live: (\S+) \| (.+?) -->$", re.MULTILINE)
FOLDER = "live"
_KEY = "live-question"


def live_file(name: str) -> Path | None:
    """The page of a file of the catalogue, kept from an earlier call or made now; None where it cannot be shared."""
    if "machine" not in load_document(name)[0]:
        return None
    return _kept_page(name, gallery.KEPT / name, None if name not in gallery.EXPENSIVE else False)


def live_files() -> dict[str, Path]:
    """The pages of all files of the catalogue that can be shared, by their names in the site; empty where none is built."""
    if not is_built():
        return {}
    pages = {name: live_file(name) for name in names()}
    return {f"{FOLDER}/{name}.html": page for name, page in pages.items() if page is not None}


def is_built() -> bool:
    """Whether this installation has the page: where npm had no network, it has not."""
    try:
        return bool(built_file("live.js"))
    except WuchtError:
        return False


def with_live_machines(name: str, page: str) -> tuple[str, dict[str, Path]]:
    """A page with its marks replaced by live machines, and their pages by their names in the site.

    name: of the page, such as ``practice/screen.md``. Where no live machine is built, a sentence says so.
    """
    if not MARK.search(page):
        return page, {}
    up, place, pages = "../" * name.count("/"), Path(name).with_suffix(""), dict[str, Path]()
    with tempfile.TemporaryDirectory() as folder:
        write_files(page, Path(folder))

        def frame(mark: re.Match[str]) -> str:
            if not is_built():
                return "*The live machine is not part of this build: npm had no network.*"
            of_page = Path(folder) / mark[1]
            if of_page.is_file():
                file = f"{FOLDER}/{place.as_posix()}-{of_page.stem}.html"
                made = _kept_page(str(of_page), gallery.KEPT / "pages" / place / of_page.stem, None)
            else:
                file, made = f"{FOLDER}/{mark[1]}.html", live_file(mark[1])
            if made is None:
                raise ValueError(f"{name}: {mark[1]} cannot be shared as a live machine")
            pages[file] = made
            return "\n".join(_frame(f"{up}{file}", mark[2]))

        return MARK.sub(frame, page), pages


def _kept_page(name: str, folder: Path, verdict: bool | None) -> Path | None:
    document, _ = load_document(name)
    question = gallery.key(repr(document), gallery.digest(), built_file("live.js"), built_file("live.css"))
    page = folder / "live.html"
    if gallery.text_of(folder / _KEY) == question:
        return page if page.is_file() else None
    folder.mkdir(parents=True, exist_ok=True)
    page.unlink(missing_ok=True)
    try:
        page.write_text(shared_page(name, verdict=verdict), encoding="utf-8")
    except WuchtError as error:
        if error.code != "not-exported":
            raise
    (folder / _KEY).write_text(question, encoding="utf-8")
    return page if page.is_file() else None


def _frame(address: str, caption: str) -> list[str]:
    return [
        '<figure class="live">',
        f'<iframe src="{address}" title="{caption}" loading="lazy"></iframe>',
        f'<figcaption>{caption} <a href="{address}">In a window of its own</a></figcaption>',
        "</figure>",
    ]
