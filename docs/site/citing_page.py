"""How to cite, from CITATION.cff."""

from __future__ import annotations

from typing import Any

from .gallery import ROOT

_AFTER = """
State the version and the file: a result has both (`summary.json`; the attributes `versions` and `input` of `result.nc`), so
that whoever reads the number can ask the same question again.

If the machine is one of the catalogue, cite its source, too: `source` in the file names the paper, and the figure or table. The
papers are listed under [sources](sources.md), with what is wrong in print under [errata](errata.md).
"""


def page() -> str:
    """How to cite the program, and what was computed with it."""
    import yaml

    about: dict[str, Any] = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    authors = " and ".join(a.get("name") or f"{a['family-names']}, {a['given-names']}" for a in about["authors"])
    title, version, year = about["title"], about["version"], about["date-released"].year
    entry = {"author": authors, "title": title, "version": version, "year": year}
    lines = ["# How to cite", "", about["message"], "", f"> {authors}: *{title}*, version {version}, {year}.", "", "```bibtex"]
    lines += [f"@software{{wucht{year},", *(f"  {key} = {{{{{value}}}}}," for key, value in entry.items()), "}", "```"]
    return "\n".join(lines) + "\n" + _AFTER
