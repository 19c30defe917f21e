"""The table [[law.segments]]: what follows from its keys, and what is refused; the motion against rise and return."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams import CamDrive, RiseTable, StandardLaw, polynomial_law
from wucht.cams.drive import cam_drive_from

DEG = math.pi / 180
PHI = np.linspace(-7, 7, 2001)
UP = {"kind": "modified-sine", "to": "90 deg", "stroke": "10 mm"}
REST = {"kind": "dwell", "to": "135 deg"}
DOWN = {"kind": "modified-sine", "to": "315 deg", "stroke": "-10 mm"}


def drive(*segments: dict[str, Any], **keys: Any) -> CamDrive:
    return cam_drive_from({"law": {"segments": list(segments), **keys}}, "a cam", None)


def motion(*segments: dict[str, Any]) -> Any:
    return drive(*segments).motion_law.function


@pytest.mark.parametrize("segments", [
    (UP, REST, DOWN),
    (UP, {"from": "135 deg"} | DOWN),
    ({"from": "0 deg"} | UP, REST, DOWN, {"kind": "dwell"}),
    ({"kind": "dwell", "from": "-45 deg", "to": "0 deg"}, UP, {"from": "135 deg"} | DOWN),
    ({"from": "135 deg"} | DOWN, {"from": "0 deg"} | UP),
    ({"from": "135 deg"} | DOWN, {"from": "720 deg"} | UP),
])  # fmt: skip
def test_rise_dwell_fall_dwell_is_rise_and_return(segments: tuple[dict[str, Any], ...]) -> None:
    """However it is written down; a motion that begins with the fall is zero above. Largest values are exact."""
    one = {"kind": "modified-sine", "stroke": "10 mm", "rise": ["0 deg", "90 deg"], "return": ["135 deg", "315 deg"]}
    expected = cam_drive_from({"law": one}, "a cam", None).motion_law
    law = drive(*segments).motion_law
    above = 0.01 if segments[0]["kind"] != "dwell" and segments[0]["stroke"] == "-10 mm" else 0.0
    for order in range(4):
        inside = np.min(np.abs(np.mod(PHI[:, None] / DEG - np.array([0, 90, 135, 315]) + 180, 360) - 180), axis=1) > 1e-3
        values = law.function(PHI[inside], order) + (above if order == 0 else 0.0)
        assert values == pytest.approx(expected.function(PHI[inside], order), rel=1e-10, abs=1e-12)
    assert [law.peak(order) for order in (1, 2, 3)] == pytest.approx([expected.peak(order) for order in (1, 2, 3)], rel=1e-12)
    assert (law.jump, law.unit) == (0.0, "m")


def test_segments_of_a_spline_run_forwards_up_and_down() -> None:
    """Points are shares of the arc and of the stroke; where a derivative jumps it is that of what begins."""
    points = [(0.3, 0.2), (0.6, 0.7)]
    spline = {"kind": "quintic-spline", "points": points}
    law = motion({"to": "100 deg", "stroke": "8 deg"} | spline, {"stroke": "-8 deg"} | spline)
    assert law(np.array([30, 60, 100, 100 + 0.3 * 260, 100 + 0.6 * 260]) * DEG) == pytest.approx(
        np.array([1.6, 5.6, 8, 6.4, 2.4]) * DEG, rel=1e-12
    )
    jerk = motion({"kind": "3-4-5", "to": "60 deg", "stroke": 0.2}, {"kind": "3-4-5", "stroke": -0.2})(
        np.array([0, 60 * DEG]), 3
    )
    assert jerk == pytest.approx([60 * 0.2 / (60 * DEG) ** 3, -60 * 0.2 / (300 * DEG) ** 3])


def test_jumps_of_the_acceleration_are_those_of_both_sides() -> None:
    """Two harmonic segments that meet without a rest: h pi^2/2/beta^2 on each side, which have the same sign at the top."""
    harmonic = "simple-harmonic"
    law = drive(
        {"kind": harmonic, "to": "90 deg", "stroke": 0.1}, {"kind": harmonic, "to": "270 deg", "stroke": -0.1}
    ).motion_law
    size = 0.1 * math.pi**2 / 2
    jumps = law.function.jumps(2)
    expected = {0: 1 / (90 * DEG) ** 2, 90: 1 / (90 * DEG) ** 2 - 1 / math.pi**2, 270: 1 / math.pi**2}
    assert {round(angle / DEG, 9): jump for angle, jump in jumps.items()} == pytest.approx(
        {k: size * v for k, v in expected.items()}
    )
    even = drive({"kind": harmonic, "to": "180 deg", "stroke": 0.1}, {"kind": harmonic, "stroke": -0.1}).motion_law
    assert even.jump == 0.0  # a cosine
    assert even.function(PHI) == pytest.approx(0.05 * (1 - np.cos(PHI)), abs=1e-14)


class Straight(RiseTable):
    """A rise of constant velocity."""

    kind: ClassVar[str] = "straight-for-tests"

    def rise_law(self) -> StandardLaw:
        return polynomial_law(np.array([0.0, 1.0]), np.array([[0.0, 1.0]]))


def test_a_law_of_ones_own_may_be_a_segment_and_a_velocity_that_jumps_is_refused() -> None:
    straight = {"kind": "straight-for-tests"}
    with refused(
        "law.segments", "the velocity jumps by 5.72958 mm/rad at 0 deg: take laws that begin and end at rest", code="jumps"
    ):
        motion({"to": "100 deg", "stroke": "10 mm"} | straight, {"kind": "3-4-5", "stroke": "-10 mm"})


LAST = {"kind": "3-4-5", "stroke": "-10 mm"}


@pytest.mark.parametrize(("segments", "location", "sentence", "code"), [
    ((UP, {"kind": "3-4-5", "stroke": "-9 mm"}), "", "segments add up to 1 mm, not to zero", "not-closed"),
    ((UP, {"from": "80 deg"} | LAST), "[1].from", "given '80 deg'; must not lie before the end of the segment before, 90", ""),
    ((UP, {"from": "90 deg", "to": "90 deg"} | LAST), "[1].to", "must lie after its begin, 90 deg, and at most at 360 deg", ""),
    ((UP, {"to": "361 deg"} | LAST), "[1].to", "given '361 deg'; must lie after its begin, 90 deg, and at most at 360", ""),
    ((UP, {"kind": "dwell"}, LAST), "[1].to", "this key is missing", "missing"),
    ((UP, {"kind": "dwell", "to": "360 deg"}, LAST), "[2].to", "must lie after its begin, 360 deg", ""),
    ((UP, {"kind": "3-4-6", "stroke": "-10 mm"}), "[1].kind", "unknown kind; did you mean '3-4-5'?", "unknown-name"),
    ((UP, {"kind": "3-4-5"}), "[1].stroke", "this key is missing; give the stroke of the output, negative", "missing"),
    ((UP, REST | {"stroke": "1 mm"}, LAST), "[1].stroke", "a dwell has none: the output rests", ""),
    ((UP, {"kind": "3-4-5", "stroke": "0 mm"}), "[1].stroke", 'other than 0; kind = "dwell" rests', ""),
    ((UP, {"kind": "3-4-5", "stroke": "-10 deg"}), "[1].stroke", "must be a displacement", "dimension"),
    ((UP, {"kind": "3-4-5", "strok": "-10 mm"}), "[1].strok", "unknown key; did you mean 'stroke'?", "unknown-key"),
    ((UP, LAST | {"points": [(0.5, 0.5)]}), "[1].points", "only a spline goes through points", ""),
    ((UP, LAST | {"kind": "cubic-spline", "points": [(0.5, 0.5), (0.4, 0.6)]}), "[1].points", "must increase", ""),
    (({"kind": "dwell"},), "", "nothing moves", "rests"),
    ((), "", "must be a list of segments, at least 1", "length"),
])  # fmt: skip
def test_what_is_refused(segments: tuple[dict[str, Any], ...], location: str, sentence: str, code: str) -> None:
    with refused(f"law.segments{location}", sentence, code=code):
        motion(*segments)


def test_segments_beside_another_kind_are_refused() -> None:
    with refused("law.segments", "unknown key", code="unknown-key"):
        drive(UP, LAST, kind="3-4-5", stroke="10 mm", rise=[0.0, 1.0])
