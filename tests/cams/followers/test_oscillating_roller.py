"""The table [follower]."""

from tests.refusals import refused

from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.numerics.fourier_series import FourierSeries

LEVER = {"pivot": "110 mm", "arm": "90 mm", "roller_radius": "10 mm", "angle": "-143 deg"}
COUNTER = {"arm": "90 mm", "roller_radius": "10 mm", "angle": "120 deg"}


def test_a_groove_and_a_counter_cam_are_one_choice():
    assert OscillatingRoller(**LEVER, counter=COUNTER).groove is False
    assert OscillatingRoller(**LEVER, groove=True).counter is None
    with refused("follower.groove", "groove = true", "counter cam", given=True):
        OscillatingRoller(**LEVER, counter=COUNTER, groove=True)


def test_both_cams_of_a_lever_are_for_the_sense_of_its_shaft():
    law = FourierSeries.of(0.1, [-0.1])
    for clockwise in (False, True):
        cams = OscillatingRoller(**LEVER, counter=COUNTER, clockwise=clockwise).make_cams(law)
        assert {name: cam.clockwise for name, cam in cams.items()} == {"cam": clockwise, "counter": clockwise}
