"""The gallery: a page for every file of the catalogue, with its figure, its answer and the paper's numbers beside ours."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import wucht
from wucht.files.catalogue import FOLDER

from .gallery import EXPENSIVE, Entry
from .live_machines import FOLDER as FOLDER_OF_LIVE
from .markdown import cell, table, toml_block
from .published import Compared, compared, published

COLLECTIONS = {
    "practice": "Machines of our own, with plausible data",
    "drozdetskaya-2020": "002, O. Drozdetskaya: a rotor with balancing pendulums and a motor of limited power",
    "sperling-rollers": "000, L. Sperling, H. Duckstein, B. Ryzhik: two rollers",
    "sperling-vibration": "001, L. Sperling, F. Merten, H. Duckstein: rotation and vibration",
    "kaltofen-cam": "004, K. Kaltofen: cams on a shaft that does not turn evenly",
}


def pages(entries: Sequence[Entry], live: Collection[str] = ()) -> dict[str, str]:
    """The pages of the gallery by file name. live: names in the site of the pages of live machines."""
    written = {f"gallery/{e.name}.md": _page(e, f"{FOLDER_OF_LIVE}/{e.name}.html" in live) for e in entries}
    return written | {"gallery/index.md": _overview(entries)}


def figures(entries: Iterable[Entry]) -> dict[str, Path]:
    """The figures that the pages show, and a panel of each for the overview, by file name."""
    shown = [e for e in entries if e.result is not None]
    return {f"gallery/{e.name}.png": e.figure for e in shown} | {f"gallery/{e.name}-panel.png": e.thumbnail for e in shown}


def _page(e: Entry, is_live: bool) -> str:
    kind = e.study_file.spec.kind
    lines = [f"# {e.about.get('title', e.name)}", "", f"`{e.name}`, study [{kind}]({_up(e)}studies/{kind}.md)", ""]
    lines += ["```sh", f"wucht run {e.name}", "```", ""]
    if is_live:
        address = f"{_up(e)}{FOLDER_OF_LIVE}/{e.name}.html"
        lines += [f'<a class="md-button" href="{address}">The live machine: move it, change it, let go</a>', ""]
    if e.about.get("source"):
        lines += [f"**Source.** {e.about['source']}", ""]
    if e.about.get("notes"):
        lines += [" ".join(e.about["notes"].split()), ""]
    return "\n".join([*lines, *_answer(e), *_beside(e), *_files(e)])


def _up(e: Entry) -> str:
    return "../" * (e.name.count("/") + 1)


def _answer(e: Entry) -> list[str]:
    if e.result is None:
        takes, how = (" It takes minutes:", "make docs GALLERY=all") if e.name in EXPENSIVE else ("", "make docs")
        sentence = f"It was not computed in this build.{takes} `{how}` computes it, once."
        return ['!!! note "No figure here"', "", f"    {sentence}", ""]
    lines = [f"![{e.about.get('title', e.name)}]({Path(e.name).name}.png)", ""]
    lines += ["```text", *wucht.report(e.result), "```", ""]
    for warning in e.result.wucht.warnings:
        lines += ["!!! warning", "", f"    {warning}", ""]
    return lines


def _beside(e: Entry) -> list[str]:
    about = published().get(e.name, {})
    lines = ["## Beside the paper", ""] if about else []
    if "shows" in about:
        lines += [f"{about['shows']}.", ""]
    if e.result is None:
        return lines
    rows = [_row(c) for c in compared(e.name, e.result.wucht.summary)]
    return [*lines, *(table(("quantity", "theirs", "who says so", "wucht", "difference"), rows) if rows else []), ""]


def _row(c: Compared) -> tuple[str, ...]:
    unit = {"deg": "°"}.get(c.unit, f" {c.unit}" if c.unit else "")
    return c.quantity, f"{c.theirs:.9g}{unit}", c.by, f"{c.ours:.9g}{unit}", f"{c.off:.1e}{unit}" if abs(c.off) < 1e6 else "-"


def _files(e: Entry) -> Iterator[str]:
    yield from _folded("The file", toml_block((FOLDER / f"{e.name}.toml").read_text(encoding="utf-8")))
    if e.result is not None:
        summary = json.dumps(_shortened(e.result.wucht.summary), indent=1, default=str, ensure_ascii=False)
        yield from _folded("Its summary.json", ["```json", *summary.splitlines(), "```"])
        made = json.loads(e.result.attrs["versions"])
        took = f"{float(e.result.attrs['elapsed_s']):.3g} s"
        yield f"Computed in {took} with " + ", ".join(f"{package} {version}" for package, version in made.items()) + "."


def _shortened(value: Any, most: int = 6) -> Any:
    """A summary with its long lists cut: they are in the file itself."""
    if isinstance(value, dict):
        return {k: _shortened(v, most) for k, v in value.items()}
    if isinstance(value, list | tuple):
        shown = [_shortened(v, most) for v in value[:most]]
        return [*shown, f"... {len(value) - most} more"] if len(value) > most else shown
    return value


def _folded(title: str, lines: Iterable[str]) -> Iterator[str]:
    yield from (f'??? note "{title}"', "", *(f"    {line}" for line in lines), "")


def _overview(entries: Sequence[Entry]) -> str:
    lines = [
        "# Gallery",
        "",
        "Every file of the catalogue, as it answers on its own: its numbers, and the paper's beside them.",
        "",
    ]
    for folder, title in _collections(entries).items():
        lines += [f"## {title}", "", '<div class="gallery" markdown>', ""]
        for e in (e for e in entries if e.name.startswith(f"{folder}/")):
            shown = f"![]({e.name}-panel.png)" if e.result is not None else ""
            lines += [f"[{shown} **{cell(e.about.get('title', e.name))}** `{e.name.partition('/')[2]}`]({e.name}.md)", ""]
        lines += ["</div>", ""]
    return "\n".join([*lines, *_all_numbers(entries)])


def _collections(entries: Iterable[Entry]) -> dict[str, str]:
    folders = dict.fromkeys(e.name.partition("/")[0] for e in entries)
    known = [f for f in COLLECTIONS if f in folders]
    return {f: COLLECTIONS.get(f, f) for f in (*known, *(f for f in folders if f not in COLLECTIONS))}


def _all_numbers(entries: Iterable[Entry]) -> list[str]:
    found = [(e, c) for e in entries if e.result is not None for c in compared(e.name, e.result.wucht.summary)]
    rows = [(f"[{e.name.partition('/')[2]}]({e.name}.md)", *_row(c)) for e, c in found]
    if not rows:
        return []
    about = "What papers and other programs say, what wucht computes, and the difference."
    head = ("file", "quantity", "theirs", "who says so", "wucht", "difference")
    return ["## Numbers beside each other", "", about, "", *table(head, rows), ""]
