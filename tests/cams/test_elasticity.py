"""Springs behind a cam: what a stiff one leaves in the dwell."""

from __future__ import annotations

import math

import numpy as np

from wucht.cams.elastic_output import Dwell, ElasticOutput
from wucht.cams.elasticity import vibrations
from wucht.cams.laws.standard_laws import RiseAndReturn, standard_law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.motion_law import RiseMotionLaw
from wucht.numerics.fourier_series import FourierSeries


def test_behind_a_stiff_spring_each_cam_rests_in_its_dwell() -> None:
    """The original cam rests while the shaft turns through its dwell, which an uneven shaft reaches later than an even one."""
    rise = RiseAndReturn(standard_law("4-5-6-7"), 0.4, (math.pi / 2, math.pi), (math.pi, 3 * math.pi / 2))
    law = RiseMotionLaw(rise, "rad")
    uneven, dwell = ShaftMotion(FourierSeries.of(50.0, [5.0], [12.0])), Dwell(-math.pi / 2, math.pi / 2)
    stiff, speeds = ElasticOutput(6.0, 6.0 * 5e4**2), np.array([40.0, 50.0])
    springs = vibrations(stiff, law, uneven, uneven, (dwell,), speeds)
    assert springs.names[:2] == ("original cam", "corrected cam")
    assert springs.deviation[:2].max() < 2e-4 * 0.4
    assert max(e.deviation for e in springs.excitations) < 2e-4 * 0.4
    assert float(uneven.time(math.pi / 2)) < math.pi / 2 - 0.1, "the dwells differ"
