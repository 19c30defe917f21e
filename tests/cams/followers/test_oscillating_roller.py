"""The table [follower]."""

import pytest

from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.errors import InputError

LEVER = {"pivot": "110 mm", "arm": "90 mm", "roller_radius": "10 mm", "angle": "-143 deg"}
COUNTER = {"arm": "90 mm", "roller_radius": "10 mm", "angle": "120 deg"}


def test_a_groove_and_a_counter_cam_are_one_choice():
    assert OscillatingRoller(**LEVER, counter=COUNTER).groove is False
    assert OscillatingRoller(**LEVER, groove=True).counter is None
    with pytest.raises(InputError, match=r"^follower.groove: given True; .* give either groove = true or a counter cam"):
        OscillatingRoller(**LEVER, counter=COUNTER, groove=True)
