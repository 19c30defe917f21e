"""The table [follower]."""

from tests.refusals import refused

from wucht.cams.followers.oscillating_roller import OscillatingRoller

LEVER = {"pivot": "110 mm", "arm": "90 mm", "roller_radius": "10 mm", "angle": "-143 deg"}
COUNTER = {"arm": "90 mm", "roller_radius": "10 mm", "angle": "120 deg"}


def test_a_groove_and_a_counter_cam_are_one_choice():
    assert OscillatingRoller(**LEVER, counter=COUNTER).groove is False
    assert OscillatingRoller(**LEVER, groove=True).counter is None
    with refused("follower.groove", "groove = true", "counter cam", given=True):
        OscillatingRoller(**LEVER, counter=COUNTER, groove=True)
