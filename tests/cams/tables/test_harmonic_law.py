"""The table [law] of a synthesised motion: what each key does, and what is refused in which words."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.laws.synthesis import band_extremes, equiripple
from wucht.cams.tables.harmonic_law import HarmonicLawTable, Resonance
from wucht.errors import InputError

TOP = {"at": "180 deg", "equals": "24 deg"}
DWELL = {"on": ["-120 deg", "120 deg"], "equals": "0 deg"}
LIMITED = DWELL | {"tolerance": "0.5 deg"}
PHI = np.linspace(0, 2 * math.pi, 2001)


def law(*restrictions, unit="rad", **more):
    return HarmonicLawTable(**{"harmonics": 5, "restrictions": list(restrictions)} | more).make_motion_law(unit)


def test_the_flattest_dwell():
    found = law(TOP, DWELL)
    ripple = math.radians(24) * 243 / 29525
    assert band_extremes(found.restrictions[1], found.function) == pytest.approx((-ripple, ripple), rel=1e-6)
    assert found.dwells == found.restrictions[1:]
    assert found.function(PHI) == pytest.approx(equiripple(5, math.radians(120), math.radians(24))(PHI), abs=1e-6)
    assert found.count == 5
    assert [r.name for r in found.restrictions] == ["law.restrictions[0]", "law.restrictions[1]"]


@pytest.mark.parametrize(
    ("of", "order", "unit"), [("velocity", 1, "deg/rad"), ("acceleration", 2, "deg/rad^2"), ("jerk", 3, "deg / rad^3")]
)
def test_bounds_of_derivatives_by_the_cam_angle(of, order, unit):
    free = law(TOP, DWELL).function.derivative(order).peak
    bound = 0.97 * math.degrees(free)
    limited = {"of": of, "min": f"{-bound} {unit}", "max": f"{bound} {unit}"}
    assert law(TOP, DWELL, limited).function.derivative(order).peak == pytest.approx(0.97 * free, rel=1e-5)


def test_caps_and_a_resonance():
    square = {"objective": "least-mean-square-acceleration", "harmonics": 8}
    free = law(TOP, LIMITED, **square).function.amplitudes
    cap = {"harmonic": 4, "amplitude": f"{0.9 * math.degrees(free[3])} deg"}
    assert law(TOP, LIMITED, **square, caps=[cap]).function.amplitudes[3] == pytest.approx(0.9 * free[3], rel=1e-5)
    highest = {"harmonic": 8, "amplitude": f"{0.9 * math.degrees(free[7])} deg"}
    assert law(TOP, LIMITED, **square, caps=[highest]).function.amplitudes[7] == pytest.approx(0.9 * free[7], rel=1e-5)
    near = {"frequency": "1900 rpm", "speed": "500 rpm", "damping_ratio": 0.01}
    assert law(TOP, LIMITED, **square, resonance=near).function.amplitudes[3] < 0.9 * free[3]


def test_the_magnification_of_an_elastic_output():
    """Of an oscillator that is moved at its base: 1/|1 - r^2 + 2 i D r|, at resonance 1/(2 D)."""
    near = Resonance(frequency=100.0, speed=50.0, damping_ratio=0.05)
    assert near.magnification(3) == pytest.approx([1 / math.hypot(0.75, 0.05), 10.0, 1 / math.hypot(1.25, 0.15)])


FEW = {"harmonics": 2, "objective": "least-peak-acceleration"}
WRONG = {
    "law.restrictions: give [[law.restrictions]], or coefficients": {"restrictions": []},
    "law.harmonics: this key is missing": {"harmonics": None},
    "law.harmonics: given 0; must be between 1 and 60|a whole number from 1 to 60": {"harmonics": 0},
    "law.restrictions[0].on: given [0.0, 1.0]; give either at or on": {"restrictions": [TOP | {"on": [0, 1]}, DWELL]},
    "law.restrictions[0]: give equals": {"restrictions": [{"at": 0}, DWELL]},
    "law.restrictions[0].min: given 2.0; must not be greater than max": {"restrictions": [{"min": 2, "max": 1}, DWELL]},
    "law.restrictions[0].on: given [0.0, 7.0]; must be an arc of at most one turn": {
        "restrictions": [{"on": [0, 7], "max": 1}, DWELL]
    },
    "law.objective: given 'flattest-dwell'; the flattest dwell needs a restriction on an arc": {"restrictions": [TOP]},
    "law.restrictions[1].tolerance: on an arc equals needs a tolerance": {"objective": "least-peak-acceleration"},
    "law.caps[0].harmonic: given 6; the law has 5 harmonics": {"caps": [{"harmonic": 6, "amplitude": 1}]},
}


@pytest.mark.parametrize(("sentence", "given"), WRONG.items())
def test_what_is_refused(sentence, given):
    with pytest.raises(InputError) as raised:
        law(**{"restrictions": [TOP, DWELL]} | given)
    assert any(str(raised.value).startswith(s) or s in str(raised.value) for s in sentence.split("|"))


def test_what_contradicts_itself_says_what_must_give_way_and_how_many_harmonics_are_enough():
    with pytest.raises(InputError) as raised:
        law(TOP, LIMITED, **FEW)
    said = str(raised.value)
    assert "no motion of 2 harmonics satisfies them all; relax law.restrictions[" in said
    assert "; 5 harmonics are enough" in said
    with refused("law.restrictions", "more than one", given=None):
        law({"at": 3, "equals": 1}, {"at": 3, "equals": 2}, {"at": 3, "equals": 3}, DWELL)


def _accelerated(harmonics, bound):
    dwell = {"on": ["-90 deg", "90 deg"], "equals": 0, "tolerance": "0.1 deg"}
    bounded = {"of": "acceleration", "min": f"-{bound} deg/rad^2", "max": f"{bound} deg/rad^2"}
    asked = [{"at": math.pi, "equals": "20 deg"}, dwell, bounded]
    return law(*asked, harmonics=harmonics, objective="least-mean-square-acceleration")


def test_bounds_of_the_acceleration_say_what_must_give_way_in_their_own_unit():
    """Each by a linear programme of its own on a fine grid (SciPy's linprog): 13.05 deg, 8.07 deg, 22.8 deg/rad^2."""
    with pytest.raises(InputError) as raised:
        _accelerated(6, 10)
    said = str(raised.value)
    for amount in (
        "restrictions[0] alone by 13 deg,",
        "restrictions[1] alone by 8.07 deg",
        "restrictions[2] alone by 22.8 deg/rad^2",
    ):
        assert amount in said


def test_more_harmonics_than_a_dwell_can_use_are_zero():
    """Of 40 harmonics rounding hides how flat it is: the fewest with which it is flat to 1e-9 of the stroke are taken."""
    found = HarmonicLawTable(harmonics=40, restrictions=[TOP, DWELL]).make_motion_law("rad").function
    assert found.bounds == pytest.approx((0.0, math.radians(24)), abs=1e-9)
    used = np.flatnonzero(found.amplitudes)[-1] + 1
    assert used == 20  # T_20((3 + c)/(1 - c)) is the first of them above 1e9, c = cos 120 deg
    assert found.count == 40


@pytest.mark.parametrize(("on", "told"), [(["120 deg", "-120 deg"], True), (["-120 deg", "120 deg"], False)])
def test_a_point_on_the_arc_that_is_to_be_flat_is_told(on, told):
    asked = HarmonicLawTable(harmonics=5, restrictions=[TOP, {"on": on, "equals": 0}])
    if not told:
        assert asked.make_motion_law("rad").count == 5
        return
    with refused("law.restrictions[0]", "law.restrictions[1]", given=None):
        asked.make_motion_law("rad")
