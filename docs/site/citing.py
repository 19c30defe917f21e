"""How to cite, from CITATION.cff."""

from __future__ import annotations

from typing import Any

import yaml

from .gallery import ROOT

_AFTER = """
State the version and the file: a result has both (`summary.json`; the attributes `versions` and `input` of `result.nc`), so
that whoever reads the number can ask the same question again.

If the machine is one of the catalogue, cite its source, too: `source` in the file names the paper, and the figure or table. The
papers are listed under [sources](sources.md), with what is wrong in print under [errata](errata.md).
"""


def pages() -> dict[str, str]:
    """The page on citing."""
    return {"citing.md": _citing(yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8")))}


def _citing(about: dict[str, Any]) -> str:
    authors = " and ".join(a.get("name") or f"{a['family-names']}, {a['given-names']}" for a in about["authors"])
    title, version, year = about["title"], about["version"], about["date-released"].year
    entry = {"author": authors, "title": title, "version": version, "year": year}
    lines = ["# How to cite", "", about["message"], "", f"> {authors}: *{title}*, version {version}, {year}.", "", "```bibtex"]
    lines += [f"@software{{wucht{year},", *(f"  {key} = {{{{{value}}}}}," for key, value in entry.items()), "}", "```"]
    return "\n".join(lines) + "\n" + _AFTER
