"""Plain pages of the server: the list of machines that can be shown, and a sentence."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import islice
from pathlib import Path
from urllib.parse import quote

from wucht.errors import InputError
from wucht.files.documents import read_toml
from wucht.reports.markup import html_text

LIST = "/machines"  # address of the list: that of a file is served at / instead, if one was given
_MOST, _MOST_FILES = 500, 5000  # machines that are listed; files of TOML that are looked into
_LARGEST = 1_000_000  # bytes of a file that is looked into
_STYLE = (
    ":root{color-scheme:light dark;font:15px/1.5 system-ui,sans-serif}body{max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "ul{columns:20rem;padding-left:1.2rem}li{break-inside:avoid;overflow-wrap:anywhere}"
)


def machine_list(folder: Path, catalogue: Sequence[str]) -> str:
    """Return a page with links to the study and machine files below a folder, and to machines of the catalogue.

    Parameters
    ----------
    folder : Path
    catalogue : sequence of str
        Names.

    Returns
    -------
    str
    """
    files = list(islice(_machine_files(folder), _MOST + 1))
    more = f"<p>More than {_MOST} files are not listed.</p>" if len(files) > _MOST else ""
    listing = _links(files[:_MOST]) if files else "<p>There are none.</p>"
    return _page(
        "Live machines",
        f"<h1>Live machines</h1><h2>Files below {html_text(str(folder), 400)}</h2>{listing}{more}"
        f"<h2>Catalogue</h2>{_links(catalogue)}",
    )


def sentence_page(sentence: str) -> str:
    """Return a page that says why there is no machine, with a link to the list."""
    return _page("wucht", f'<p>{html_text(sentence, 2000)}</p><p><a href="{LIST}">All machines</a></p>')


def _machine_files(folder: Path) -> Iterator[str]:
    """Yield the names of TOML files below a folder that have a machine, without those of hidden folders and behind links."""
    for path in islice(_toml_files(folder), _MOST_FILES):
        if _has_machine(path):
            yield path.relative_to(folder).as_posix()


def _toml_files(folder: Path) -> Iterator[Path]:
    for parent, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(name for name in files if name.endswith(".toml") and not name.startswith(".")):
            path = Path(parent, name)
            if not path.is_symlink():
                yield path


def _has_machine(path: Path) -> bool:
    """True for a file with a table ``[machine]``, and for one that cannot be read: its page says why."""
    try:
        about = path.stat()
    except OSError:
        return False
    return about.st_size > _LARGEST or _reads_machine(path, about.st_ino, about.st_size, about.st_mtime_ns, about.st_ctime_ns)


@lru_cache(maxsize=2 * _MOST_FILES)
def _reads_machine(path: Path, *_version: int) -> bool:
    """Whether this version of a file has the table: a file is read once, until it changes."""
    try:
        return "machine" in read_toml(path)
    except InputError:
        return True


def _links(names: Iterable[str]) -> str:
    entries = (f'<li><a href="/machine/{quote(os.fsencode(name))}">{html_text(name, 400)}</a></li>' for name in names)
    return f"<ul>{''.join(entries)}</ul>"


def _page(title: str, body: str) -> str:
    head = f'<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1"><style>{_STYLE}</style>'
    return f'<!doctype html><html lang="en"><head>{head}<title>{html_text(title, 160)}</title></head><body>{body}</body></html>'
