"""Damage counted piece by piece is that of the whole history."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.fatigue.accumulated_damage import AccumulatedDamage
from wucht.fatigue.rainflow_counting import rainflow
from wucht.fatigue.woehler_line import WoehlerLine

LINE = WoehlerLine(k=5, ND=1e3, SD=2.0, k2=9)
VALUES = st.lists(st.integers(-5, 5).map(float), max_size=60)


@settings(max_examples=60, deadline=None)
@given(pieces=st.lists(VALUES, max_size=5))
def test_in_pieces_and_at_once(pieces):
    damage = AccumulatedDamage(LINE)
    for i, piece in enumerate(pieces):
        damage = damage.after(np.array(piece))
        history = np.array([x for one in pieces[: i + 1] for x in one])
        assert damage.total == pytest.approx(LINE.damages(rainflow(history)).sum(), rel=1e-12)
        assert len(damage.open_points) <= 2 * 11  # of eleven values: ranges that grow, then ranges that shrink


def test_constant_amplitude_in_closed_form():
    damage = AccumulatedDamage(LINE)
    for _ in range(4):
        damage = damage.after(np.array([4.0, -4.0] * 100))
    assert damage.total == pytest.approx(399.5 * 2.0**5 / 1e3)
