"""Every equation in ``errata``: an exact zero where the print is right, none where it is wrong, and the page says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from errata import CHECKS, Check, is_zero, page

PAGE = Path(__file__).parents[2] / "docs" / "errata.md"


@pytest.mark.parametrize("check", CHECKS, ids=str)
def test_the_residual_of_what_is_right_is_zero_and_of_a_misprint_is_not(check: Check) -> None:
    assert is_zero(check.of_correction if check.misprinted else check.of_print)
    assert is_zero(check.of_print) is not check.misprinted


def test_the_page_is_what_the_checks_say() -> None:
    """``python -m tests.validation.errata`` writes it."""
    assert PAGE.read_text(encoding="utf-8") == page(CHECKS)
