"""The figure of every study, from its own template: complete, readable in grey, nothing beyond the page or upon anything."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from docs.site import gallery

import figure_checks
from wucht import JOURNAL, PRINT, draw
from wucht.files.catalogue import names
from wucht.results.output_folder import load_result
from wucht.studies.registry import studies


@pytest.mark.parametrize(
    ("text", "repeats"),
    [
        ("torque (10³ N·m)", False), ("range 21.94 mm; damage 0.001294", False), ("at (-0.9, -0.2) m", False),
        ("speed in rad/s (rad/s)", True), ("period\n(s) (s)", True), ("the largest 3 mm mm", True), ("at 0.0005 N m s", True),
    ],
)  # fmt: skip
def test_the_check_of_units(text: str, repeats: bool) -> None:
    assert figure_checks.repeats_unit(text) == repeats


QUICK = ("coast-down", "torque-balance")  # one with a panel over time, one over the speed
KINDS = [k if k in QUICK else pytest.param(k, marks=pytest.mark.slow) for k in studies() if studies()[k].template]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.filterwarnings("error:.*:UserWarning:matplotlib")
def test_the_figure_of_its_template(kind: str, wucht: Callable[..., Any]) -> None:
    """On a page, and in a column of a journal or across both, where every letter has 8 points and there is no title."""
    assert wucht("new", kind).code == 0
    done = wucht("run", f"{kind}.toml", "-o", "out", "--style", "journal", "--format", "svg")
    assert done.code == 0, done.err
    drawn = (Path("out") / f"{kind}.svg").read_text(encoding="utf-8")
    assert [mm for mm in (88, 180) if f'width="{mm / 25.4 * 72:.6f}'[:12] in drawn], "of the width of the journal"
    result = load_result(Path("out/result.nc"))
    figure_checks.check(draw(result, PRINT))
    column = draw(result, JOURNAL)
    figure_checks.check(column)
    assert column.get_suptitle() == ""
    assert figure_checks.sizes(column) == {8.0}


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_the_figure_of_a_file_of_the_catalogue(name: str) -> None:
    """Of the result that the gallery keeps, or that is computed now."""
    result = gallery.entry(name).result
    for page in (PRINT, JOURNAL):
        figure_checks.check(draw(result, page))
