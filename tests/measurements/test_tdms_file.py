"""TDMS files, written with npTDMS."""

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from tests.refusals import refused

from wucht.measurements.reading import read_recording
from wucht.measurements.recording import SPEED

VALUES = np.array([60.0, 90, 120])


def write(path, *channels):
    with TdmsWriter(str(path)) as writer:
        writer.write_segment([ChannelObject(group, name, values, properties=told) for group, name, values, told in channels])


def test_a_waveform(tmp_path):
    path = tmp_path / "r.tdms"
    write(path, ("g", "speed", VALUES, {"wf_increment": 0.1, "wf_start_offset": 1.0, "unit_string": "rpm"}))
    found = read_recording(path)
    assert found.names == ("speed",)
    speed = found.channel("speed", SPEED)
    assert speed.time == pytest.approx([1, 1.1, 1.2])
    assert speed.values == pytest.approx(VALUES * np.pi / 30)


def test_a_channel_of_times(tmp_path):
    path = tmp_path / "r.tdms"
    write(path, ("g", "Time", np.array([0, 5, 20]), {"unit_string": "ms"}), ("g", "x", VALUES.astype(np.int16), {}))
    channel = read_recording(path).channel("x")
    assert (channel.time.tolist(), channel.values.tolist(), channel.unit) == ([0, 0.005, 0.02], [60, 90, 120], "")


def test_groups_with_channels_of_one_name(tmp_path):
    path = tmp_path / "r.tdms"
    told = {"wf_increment": 0.1}
    write(path, ("a", "x", VALUES, told), ("b", "x", 2 * VALUES, told), ("b", "y", VALUES, told))
    found = read_recording(path)
    assert found.names == ("a/x", "b/x", "y")
    assert found.channel("b/x").values.tolist() == [120, 180, 240]


def test_a_channel_without_time(tmp_path):
    path = tmp_path / "r.tdms"
    write(path, ("g", "x", VALUES, {}))
    with refused("r.tdms: x", code="no-time"):
        read_recording(path).channel("x")


def test_text_is_no_channel_of_numbers(tmp_path):
    path = tmp_path / "r.tdms"
    write(path, ("g", "x", ["a", "b", "c"], {"wf_increment": 0.1}), ("g", "y", VALUES, {"wf_increment": 0.1}))
    with refused("r.tdms: x", code="no-numbers"):
        read_recording(path).channel("x")
    assert read_recording(path).channel("y").values.tolist() == VALUES.tolist(), "it does not hinder the others"


def test_what_is_no_tdms(tmp_path):
    path = tmp_path / "bad.tdms"
    path.write_text("hello")
    with refused("bad.tdms", "TDMS", code="unreadable"):
        read_recording(path)
