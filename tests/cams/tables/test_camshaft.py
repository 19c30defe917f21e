from __future__ import annotations

import numpy as np
import pytest
from tests.refusals import refused

import wucht
from wucht.cams.tables.camshaft import CamshaftDrive, ElasticTable, ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.numerics.fourier_series import even_angles

HELD = {"kind": "constant-speed", "speed": 100.0}


LAW = HarmonicLawTable(harmonics=2, coefficients={"mean": 0.1, "cosine": [-0.1]})


def test_the_motion_for_which_a_cam_is_corrected() -> None:
    held = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=6.0, drive=HELD | {"speed": 50.0}))
    motion = held.corrected_shaft_motion
    assert motion.mean == pytest.approx(50.0) and motion.fluctuation == pytest.approx(0.0, abs=1e-12)
    free = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=6.0, mean_speed=50.0)).corrected_shaft_motion
    assert free.mean == pytest.approx(50.0) and free.fluctuation > 1e-4
    linear = {"kind": "linear", "slope": 50.0, "no_load_speed": 55.0}
    load = {"kind": "viscous", "coefficient": 2.0}
    driven = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=600.0, drive=linear, loads=[load]))
    speed = driven.corrected_shaft_motion.speed(even_angles(512))
    assert np.mean((50 * (55 - speed) - 2 * speed) * speed) == pytest.approx(0.0, abs=1e-6 * 50 * 55**2), "work in, work out"
    assert np.ptp(speed) > 1e-3 * speed.mean()
    with refused("speed", given=None, code="missing"):
        _ = wucht.CamDrive(LAW).corrected_shaft_motion


def test_the_damping_of_an_output_on_a_spring() -> None:
    """Given itself, or by its ratio to the critical one, 2 sqrt(c m)."""
    common = {"output_stiffness": 400.0}
    assert ElasticTable(**common, output_damping=3.0).output(4.0, "rad").damping == 3.0
    assert ElasticTable(**common, output_damping_ratio=0.25).output(4.0, "rad").damping == pytest.approx(0.25 * 2 * 40.0)
    with refused("shaft.elastic.output_damping", "negative", given=-3.0):
        ElasticTable(**common, output_damping=-3.0).output(4.0, "rad")
    with refused("shaft.elastic.output_stiffness", "above zero", given=0.0):
        ElasticTable(output_stiffness=0.0).output(4.0, "rad")


def test_the_motor_behind_a_gear_turns_with_the_shaft() -> None:
    shaft = ShaftTable(inertia=20.0, output_inertia=6.0, mean_speed=50.0)
    geared = CamshaftDrive(lambda v: (np.zeros((2, *np.shape(v))),) * 2, speed=48.0, is_enforced=False, inertia=3.5)
    assert (shaft.camshaft(geared, "rad").inertia, shaft.camshaft(None, "rad").inertia) == (23.5, 20.0)
    assert (shaft.camshaft(geared, "rad").mean_speed, shaft.camshaft(None, "rad").mean_speed) == (48.0, 50.0)
