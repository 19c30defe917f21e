"""Dwells of laws, and how far a motion is off them: by values known by pencil; lengths of the arms of outputs."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from wucht.cams.drive import cam_drive_from
from wucht.cams.dwells import dwells_of, position_error
from wucht.cams.elastic_output import Dwell

STANDARD = {"kind": "3-4-5", "stroke": "10 mm", "rise": ["60 deg", "150 deg"], "return": ["200 deg", "300 deg"]}
LEVER = {"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07, "roller_radius": 0.01, "angle": "-135 deg"}
ROD = {"kind": "translating-roller", "distance": "60 mm", "roller_radius": "12 mm"}
FOUR_BAR = {"kind": "four-bar", "ground": 0.3, "input": 0.1, "coupler": 0.29, "output": 0.12, "angle": "70 deg"}
SLIDER = {"kind": "slider-crank", "crank": "50 mm", "rod": "200 mm", "angle": "60 deg"}


def test_a_late_motion_is_off_by_what_it_has_not_yet_done():
    """A straight line: 0.1 a radian, from its value at the begin on; a dwell past the end of the turn too."""
    line = lambda tau: 0.1 * np.asarray(tau)  # noqa: E731
    assert position_error(line, [Dwell(1.0, 2.0, 0.1)]) == pytest.approx(0.1)
    assert position_error(line, [Dwell(1.0, 2.0, 0.1), Dwell(6.0, 1.0, 0.6)]) == pytest.approx(0.1 * (1 + 2 * math.pi) - 0.6)
    assert position_error(np.sin, [Dwell(0.0, 3.0)]) == pytest.approx(1.0, rel=1e-6)


def test_a_standard_law_rests_where_it_neither_rises_nor_returns():
    motion_law = cam_drive_from({"law": STANDARD}, "", None).motion_law
    top, bottom = sorted(dwells_of(motion_law), key=lambda d: d.begin)
    assert np.degrees([top.begin, top.end]) == pytest.approx([150, 200], abs=0.11)
    assert np.degrees([bottom.begin, bottom.end]) == pytest.approx([300, 420], abs=0.11)
    assert (top.value, bottom.value) == pytest.approx((0.01, 0.0), abs=1e-15)
    assert position_error(motion_law.function, [top, bottom]) < 1e-15


@pytest.mark.parametrize(
    ("tables", "arm"),
    [({"follower": LEVER}, 0.07), ({"follower": LEVER, "linkage": FOUR_BAR}, 0.12), ({"follower": ROD}, None), ({}, None),
     ({"follower": LEVER, "linkage": SLIDER}, None)],
)  # fmt: skip
def test_the_arm_of_an_output_that_turns(tables, arm):
    law = {"kind": "harmonic", "coefficients": {"cosine": [0.001]}}
    assert cam_drive_from({"law": law, **tables}, "", None).output_arm == arm


def test_a_restriction_to_a_band_is_a_dwell_in_its_middle():
    bands = (SimpleNamespace(begin=1.0, end=2.0, low=0.1, high=0.3), SimpleNamespace(begin=3.0, end=4.0, low=-0.2, high=-0.2))
    law = SimpleNamespace(dwells=bands)
    assert [(d.begin, d.end, d.value) for d in dwells_of(law)] == [(1.0, 2.0, pytest.approx(0.2)), (3.0, 4.0, -0.2)]
