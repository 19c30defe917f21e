"""Sound files of each width."""

import numpy as np
import pytest
from scipy.io import wavfile
from tests.refusals import refused

from wucht.measurements.recording import SPEED
from wucht.measurements.sound_file import read_sound


@pytest.mark.parametrize(("kind", "full"), [(np.int16, 2**15), (np.int32, 2**31), (np.float32, 1.0), (np.float64, 1.0)])
def test_full_scale_is_one(tmp_path, kind, full):
    path = tmp_path / "r.wav"
    wavfile.write(path, 1000, np.array([[0, 0.25 * full], [0.5 * full, -full / 2], [-0.125 * full, 0]]).astype(kind))
    found = read_sound(path)
    assert found.names == ("1", "2")
    assert found.channel("1").values.tolist() == [0, 0.5, -0.125]
    assert found.channel("2").values.tolist() == [0.25, -0.5, 0]
    assert found.channel("2").time == pytest.approx([0, 0.001, 0.002])


def test_eight_bits_have_their_zero_in_the_middle(tmp_path):
    path = tmp_path / "r.wav"
    wavfile.write(path, 8000, np.array([0, 128, 192], np.uint8))
    assert read_sound(path).channel("1").values.tolist() == [-1, 0, 0.5]


def test_it_has_no_unit(tmp_path):
    path = tmp_path / "r.wav"
    wavfile.write(path, 1000, np.array([0.1, 0.2], np.float32))
    channel = read_sound(path).channel("1")
    with refused("r.wav: 1", code="full-scale"):
        channel.in_si(SPEED)
    assert channel.scaled(1000, "rpm").in_si(SPEED).values == pytest.approx([10.472, 20.944], rel=1e-4)


def test_it_has_samples(tmp_path):
    path = tmp_path / "r.wav"
    wavfile.write(path, 1000, np.array([], np.int16))
    with refused("r.wav", code="unreadable"):
        read_sound(path)
