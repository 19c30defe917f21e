"""Damage by hand, and by pyLife."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pylife.strength import Fatigue
from pylife.stress.collective import LoadCollective

from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.counting import rainflow
from wucht.fatigue.damage import AccumulatedDamage, WoehlerLine, slope_below

K, ND, SD = 5.0, 2e6, 100.0
RULES = ("original", "elementary", "haibach")


@pytest.mark.parametrize("miner", RULES)
def test_constant_amplitude_is_the_share_of_its_life(miner):
    line = WoehlerLine(K, ND, SD, slope_below(K, miner))
    history = np.array([150, -150] * 1000 + [150.0])
    damage = line.damages(rainflow(history)).sum()
    assert damage == pytest.approx(1000 / (ND * 1.5**-5), rel=1e-12)
    assert line.life(np.array([SD, 2 * SD])).tolist() == pytest.approx([ND, ND / 32])


def test_below_the_knee_the_rules_differ():
    at = np.array([50.0])
    lives = [float(WoehlerLine(K, ND, SD, slope_below(K, miner)).life(at)[0]) for miner in RULES]
    assert lives == pytest.approx([np.inf, ND * 2**5, ND * 2**9])


@pytest.mark.parametrize("miner", RULES)
def test_against_pylife(miner):
    assert issubclass(Fatigue, object) and LoadCollective.__name__ == "LoadCollective"  # they register the accessors
    cycles = rainflow(120 * np.random.default_rng(5).standard_normal(2000))
    collective = pd.DataFrame({"range": cycles.ranges, "mean": cycles.means, "cycles": cycles.counts})
    curve = pd.Series({"k_1": K, "ND": ND, "SD": SD}).fatigue
    expected = getattr(curve, f"miner_{miner}")().damage(collective.load_collective).to_numpy()
    found = WoehlerLine(K, ND, SD, slope_below(K, miner)).damages(cycles)
    assert found == pytest.approx(expected, rel=1e-12)
    assert found.sum() > 0 and (found == 0).any() == (miner == "original")


def test_no_cycles_do_no_damage():
    assert WoehlerLine(K, ND, SD, K).damages(LoadCycles.empty()).sum() == 0


LINE = WoehlerLine(k=5, ND=1e3, SD=2.0, k2=9)
VALUES = st.lists(st.integers(-5, 5).map(float), max_size=60)


@settings(max_examples=60, deadline=None)
@given(pieces=st.lists(VALUES, max_size=5))
def test_in_pieces_and_at_once(pieces):
    damage = AccumulatedDamage(LINE)
    for i, piece in enumerate(pieces):
        damage = damage.update(np.array(piece))
        history = np.array([x for one in pieces[: i + 1] for x in one])
        assert damage.total == pytest.approx(LINE.damages(rainflow(history)).sum(), rel=1e-12)
        assert len(damage.open_points) <= 2 * 11  # of eleven values: ranges that grow, then ranges that shrink


def test_constant_amplitude_in_closed_form():
    damage = AccumulatedDamage(LINE)
    for _ in range(4):
        damage = damage.update(np.array([4.0, -4.0] * 100))
    assert damage.total == pytest.approx(399.5 * 2.0**5 / 1e3)
