"""MDF files, written with asammdf."""

import numpy as np
import pytest
from asammdf import MDF, Signal
from tests.refusals import refused

from wucht.measurements.reading import read_recording
from wucht.measurements.recording import SPEED

T, FAST = np.array([0.5, 0.6, 0.9]), np.arange(6) / 20


def write(path, *groups):
    with MDF() as file:
        for signals in groups:
            file.append([Signal(np.asarray(v), timestamps=t, name=n, unit=u, encoding="utf-8") for n, t, v, u in signals])
        return file.save(path, overwrite=True)


def test_channels_each_over_its_own_time(tmp_path):
    path = tmp_path / "r.mf4"
    write(path, [("speed", T, [60.0, 90, 120], "rpm")], [("x", FAST, FAST**2, ""), ("n", FAST, np.arange(6), "")])
    found = read_recording(path)
    assert sorted(found.names) == ["n", "speed", "x"]
    speed = found.channel("speed", SPEED)
    assert speed.time.tolist() == T.tolist()
    assert speed.values == pytest.approx(np.array([60, 90, 120]) * np.pi / 30)
    assert found.channel("x").values.tolist() == (FAST**2).tolist()
    assert found.channel("n").time.tolist() == FAST.tolist()


def test_groups_with_channels_of_one_name(tmp_path):
    path = tmp_path / "r.mf4"
    write(path, [("x", T, [1.0, 2, 3], "")], [("x", T, [4.0, 5, 6], "")])
    found = read_recording(path)
    assert found.names == ("0/x", "1/x")
    assert found.channel("1/x").values.tolist() == [4, 5, 6]


def test_text_is_no_channel_of_numbers(tmp_path):
    path = tmp_path / "r.mf4"
    write(path, [("state", T, np.array([b"on", b"off", b"on"]), ""), ("x", T, [1.0, 2, 3], "")])
    with refused("r.mf4: state", code="no-numbers"):
        read_recording(path).channel("state")
