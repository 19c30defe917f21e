"""Build the site: ``python -m docs.site`` in the project's folder, which writes ``build/site/index.html``.

What the catalogue's files answer is computed where it was not yet; those that take minutes only with ``--gallery all``.
``--gallery kept`` computes nothing.
"""

from __future__ import annotations

import argparse
import logging
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from . import api_page, citing_page, gallery_pages, notebooks, reference_pages
from .gallery import EXPENSIVE, ROOT, Entry, entry, names
from .gallery_pages import COLLECTIONS
from .live_machines import live_files, with_live_machines
from .markdown import naturally
from .page_figures import with_figures
from .paper_links import with_paper_links
from .printed_equations import with_equations

NEEDED = ("mkdocs", "material", "mkdocstrings", "latex2mathml", "yaml", "nbclient", "nbconvert", "ipykernel")
_OWN = ("README.md", "index.md")  # the page of a folder itself
HERE, PAGES, SITE = Path(__file__).parent, ROOT / "build" / "docs", ROOT / "build" / "site"
NAVIGATION: list[Any] = [
    {"Start": ["index.md", "which-question.md", "citing.md", "changes.md"]},
    {
        "Tutorials": [
            "tutorials/engineer.md", "tutorials/researcher.md", "tutorials/student.md", "journeys.md",
            {"Notebooks": "notebooks/*"},
        ]
    },
    {
        "Guide": [
            "machine-files.md", "from-nameplate-to-file.md", "outcomes.md", "reports.md", "live-machine.md",
            "slow-equations.md", "switchable-pendulums.md", "load-spectra.md",
            "fatigue.md", "cam-files.md", "continuation.md", "averaging.md", "how-the-rotating-orbit-disappears.md",
            "several-machines.md", "what-may-be-trusted.md",
            "*", {"Machines to try": "practice/*"},
        ]
    },
    {"Reference": ["study-files.md", {"Studies": "studies/*"}, {"Parts": "parts/*"}, "symbols.md", "sources.md", "api.md"]},
    {"Gallery": "gallery/*"},
    {"Theory": ["theory.md", "errata.md", "design.md"]},
]  # fmt: skip


def main() -> None:
    """Write the pages, then have MkDocs make the site of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--gallery", choices=("quick", "all", "kept"), default="quick", help="what is computed if it is not kept"
    )
    wanted = parser.parse_args().gallery
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        sys.exit(f"missing: {', '.join(missing)}; pip install 'wucht[docs]', or make docs")
    entries = []
    for i, name in enumerate(sorted(names(), key=naturally), 1):
        print(f"[{i}/{len(names())}] {name}", flush=True)
        entries.append(entry(name, compute=wanted == "all" or (wanted == "quick" and name not in EXPENSIVE)))
    write(entries, compute=wanted != "kept")
    build()
    print(f"Look at {SITE / 'index.html'}")


def write(entries: list[Entry], compute: bool = True) -> None:
    """All pages into a folder: those of docs/, those from schemas, and the gallery. compute: the figures of pages, too."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(HERE.parent, PAGES, ignore=shutil.ignore_patterns("site", "__pycache__"))
    shutil.copytree(HERE / "assets", PAGES / "assets", dirs_exist_ok=True)
    live = live_files() if len(entries) == len(names()) else {}
    pages = gallery_pages.pages(entries, live) | reference_pages.pages(entries)
    pages |= {"api.md": api_page.page(), "citing.md": citing_page.page()}
    pages["changes.md"] = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").replace("](docs/", "](")
    for name, text in pages.items():
        _file(name).write_text(text, encoding="utf-8")
    for name, figure in gallery_pages.figures(entries).items():
        shutil.copy(figure, _file(name))
    notebooks.write_pages(PAGES)
    for page in PAGES.rglob("*.md"):
        name = page.relative_to(PAGES).as_posix()
        text, pictures = with_figures(name, page.read_text(encoding="utf-8"), compute)
        text, machines = with_live_machines(name, text)
        live |= machines
        page.write_text(with_paper_links(name, with_equations(text)), encoding="utf-8")
        for file, picture in pictures.items():
            shutil.copy(picture, _file(file))
    for name, machine in live.items():
        shutil.copy(machine, _file(name))


def _file(name: str) -> Path:
    (PAGES / name).parent.mkdir(parents=True, exist_ok=True)
    return PAGES / name


def build() -> None:
    """HTML of the pages. Raises ``mkdocs.exceptions.Abort`` for a link that leads nowhere, after a line that says which."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    from mkdocs.commands.build import build as make
    from mkdocs.config import load_config

    nav = [_expanded(item) for item in NAVIGATION]
    make(load_config(str(HERE / "mkdocs.yml"), docs_dir=str(PAGES), site_dir=str(SITE), nav=nav))


def _expanded(item: Any) -> Any:
    """Navigation with ``folder/*`` replaced by the pages there, a section for each folder inside, and ``*`` by all others."""
    if isinstance(item, dict):
        return {title: _listed(inner) for title, inner in item.items()}
    return item


def _listed(inner: Any) -> Any:
    listed: list[Any] = []
    for item in inner if isinstance(inner, list) else [inner]:
        if item == "*":
            listed += [p.name for p in sorted(PAGES.glob("*.md")) if f"'{p.name}'" not in repr(NAVIGATION)]
        elif isinstance(item, str) and item.endswith("/*"):
            folder = PAGES / item.removesuffix("/*")
            listed += [*_own(folder), *_of_folder(folder)]
        else:
            listed.append(_expanded(item))
    return listed


def _of_folder(folder: Path) -> list[Any]:
    """What a folder has, in order, the collections of the gallery as there; a page has the title in its first line."""
    inside = [p for p in folder.iterdir() if p.is_dir() or (p.suffix == ".md" and p.name not in _OWN)]
    first = list(COLLECTIONS)
    below = sorted(
        inside, key=lambda path: (first.index(path.name) if path.name in first else len(first), naturally(path.stem))
    )
    return [{_titled(p): [*_own(p), *_of_folder(p)]} if p.is_dir() else p.relative_to(PAGES).as_posix() for p in below]


def _own(folder: Path) -> list[str]:
    return [(folder / name).relative_to(PAGES).as_posix() for name in _OWN if (folder / name).is_file()]


def _titled(folder: Path) -> str:
    return COLLECTIONS.get(folder.name, folder.name.replace("-", " ").capitalize())


if __name__ == "__main__":
    main()
