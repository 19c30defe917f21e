"""The study from the command line: its template."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

Answered = Callable[..., dict[str, Any]]


@pytest.mark.slow
def test_its_template_runs_and_is_drawn_again(from_template: Answered) -> None:
    """Two of its orientations, one phase, until just after the pendulums have opened."""
    summary = from_template(
        "activation",
        "--set",
        "study.until=1.6 s",
        "--set",
        'study.orientations=["90 deg", "180 deg"]',
        "--set",
        "study.phases=1",
    )
    assert [g["all_open"] for g in summary["switchable"]] == [1, 1]
    assert summary["pendulums"][0]["opening"] == [pytest.approx(150.0)]
    assert summary["rigid"][0]["peak_amplitude"] > 2 * summary["switchable"][0]["peak_amplitude"]
