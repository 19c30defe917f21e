"""The largest magnitude on an arc of many series at once: against each one alone and against a fine grid."""

import math

import numpy as np
import pytest

from wucht.cams.elastic_output import Dwell, ElasticOutput
from wucht.cams.largest_on_arc import largest_on_arc
from wucht.numerics.harmonics import Harmonics

TURN = 2 * math.pi


@pytest.mark.parametrize(("begin", "arc"), [(0.0, TURN), (-2.0, 4.0), (1.0, 0.05), (3.0, 0.0)])
@pytest.mark.parametrize("orders", [0, 1, 12])
def test_it_is_that_of_a_fine_grid(begin, arc, orders):
    random = np.random.default_rng(7)
    mean, waves = random.normal(size=70), random.normal(size=(70, orders)) + 1j * random.normal(size=(70, orders))
    found = largest_on_arc(begin, arc, mean, waves)
    x = begin + np.linspace(0, arc, 20001)
    on_grid = np.abs(mean[:, None] + (waves @ np.exp(1j * np.outer(np.arange(1, orders + 1), x))).real).max(axis=1)
    assert (found >= on_grid * (1 - 1e-12)).all()
    assert found == pytest.approx(on_grid, rel=1e-5)


def test_an_extremum_beside_an_end_is_found():
    """Between the first two samples, the first being the larger one."""
    assert largest_on_arc(-0.02, 2.0, np.zeros(1), np.ones((1, 1), complex)) == pytest.approx(1.0, abs=1e-15)


def test_it_is_that_at_the_stationary_points():
    series = Harmonics.of(0.3, [1.0, -0.2, 0.0, 0.4], [0.0, 0.7, 0.1])
    assert Dwell(0.0, TURN).largest(series) == pytest.approx(series.peak, rel=1e-15)


def test_many_speeds_at_once_are_each_alone():
    output, lever = ElasticOutput(0.05, 2000.0, 0.05), Harmonics.of(0.0, [1.0, 0.2, 0.05], [0.0, 0.1])
    dwells, speeds = [Dwell(-0.5, 0.5, 1.2), Dwell(2.0, 2.5)], np.linspace(20.0, 90.0, 7)
    swept = output.residual_over_speed(lever, speeds, dwells)
    alone = [output.residual(lever, float(w), dwells) for w in speeds]
    assert swept.deviation == pytest.approx([a.deviation for a in alone], rel=1e-14)
    assert swept.acceleration == pytest.approx([a.acceleration for a in alone], rel=1e-14)
