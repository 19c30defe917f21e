"""Damage by hand, and by pyLife."""

import numpy as np
import pandas as pd
import pytest
from pylife.strength import Fatigue
from pylife.stress.collective import LoadCollective

from wucht.fatigue.counted_cycles import Cycles
from wucht.fatigue.rainflow_counting import rainflow
from wucht.fatigue.woehler_line import WoehlerLine, slope_below

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
    assert WoehlerLine(K, ND, SD, K).damages(Cycles.none()).sum() == 0
