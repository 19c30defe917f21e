"""When steady phases at a held speed count as stable: every deviation decays, by more than rounding makes of nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations import averaged_stability


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(
    ("slowest", "stable"), [(-1e-3, True), (-1e-8, True), (-1e-10, False), (0.0, False), (1e-10, False), (1e-3, False)]
)
def test_neutral_is_relative_to_the_fastest_rate(size: float, slowest: float, stable: bool, monkeypatch: Any) -> None:
    """As far as 1e-9 of it, in whatever unit of time."""
    matrices = size * np.diag([-1.0, slowest, -0.3])[None]
    monkeypatch.setattr(averaged_stability, "averaged_matrices", lambda *_: matrices)
    held: Any = None
    assert averaged_stability.transverse_stability(held, np.ones(1), np.zeros((3, 1)), 0).tolist() == [stable]
