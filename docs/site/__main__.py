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

from . import api_page, citing_page, gallery_pages, reference_pages
from .gallery import EXPENSIVE, ROOT, Entry, entry, names
from .markdown import naturally
from .printed_equations import with_equations

NEEDED = ("mkdocs", "material", "mkdocstrings", "latex2mathml", "yaml")
_OWN = ("README.md", "index.md")  # the page of a folder itself
HERE, PAGES, SITE = Path(__file__).parent, ROOT / "build" / "docs", ROOT / "build" / "site"
NAVIGATION: list[Any] = [
    {"Start": ["index.md", "citing.md", "changes.md"]},
    {"Tutorials": ["tutorials/engineer.md", "tutorials/researcher.md", "tutorials/student.md"]},
    {
        "Guide": [
            "machine-files.md", "outcomes.md", "reports.md", "slow-equations.md", "switchable-pendulums.md", "load-spectra.md",
            "fatigue.md", "cam-files.md", "continuation.md", "averaging.md", "how-the-rotating-orbit-disappears.md",
            "several-machines.md",
            "*", {"Machines to try": "practice/*"},
        ]
    },
    {"Reference": ["study-files.md", {"Studies": "studies/*"}, {"Parts": "parts/*"}, "symbols.md", "sources.md", "api.md"]},
    {"Gallery": "gallery/*"},
    {"Theory": ["theory.md", "errata.md", "design.md"]},
]  # fmt: skip


def main() -> None:
    """Write the pages, then have MkDocs make the site of them."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument(
        "--gallery", choices=("quick", "all", "kept"), default="quick", help="what is computed if it is not kept"
    )
    wanted = asked.parse_args().gallery
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        sys.exit(f"missing: {', '.join(missing)}; pip install 'wucht[docs]', or make docs")
    entries = []
    for i, name in enumerate(sorted(names(), key=naturally), 1):
        print(f"[{i}/{len(names())}] {name}", flush=True)
        entries.append(entry(name, compute=wanted == "all" or (wanted == "quick" and name not in EXPENSIVE)))
    write(entries)
    build()
    print(f"Look at {SITE / 'index.html'}")


def write(entries: list[Entry]) -> None:
    """All pages into a folder: those of docs/, those from schemas, and the gallery."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(HERE.parent, PAGES, ignore=shutil.ignore_patterns("site", "__pycache__"))
    shutil.copytree(HERE / "assets", PAGES / "assets", dirs_exist_ok=True)
    pages = gallery_pages.pages(entries) | reference_pages.pages(entries)
    pages |= {"api.md": api_page.page(), "citing.md": citing_page.page()}
    pages["changes.md"] = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    for name, text in pages.items():
        _file(name).write_text(text, encoding="utf-8")
    for name, figure in gallery_pages.figures(entries).items():
        shutil.copy(figure, _file(name))
    for page in PAGES.rglob("*.md"):
        page.write_text(with_equations(page.read_text(encoding="utf-8")), encoding="utf-8")


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
    inside = [p for p in folder.iterdir() if p.is_dir() or (p.suffix == ".md" and p.name not in _OWN)]
    below = sorted(inside, key=lambda path: naturally(path.stem))
    return [{_titled(p): [*_own(p), *_of_folder(p)] if p.is_dir() else p.relative_to(PAGES).as_posix()} for p in below]


def _own(folder: Path) -> list[str]:
    return [(folder / name).relative_to(PAGES).as_posix() for name in _OWN if (folder / name).is_file()]


def _titled(path: Path) -> str:
    return path.name.removesuffix(".md")


if __name__ == "__main__":
    main()
