"""Universal files, written with pyuff."""

import numpy as np
import pytest
import pyuff
from tests.refusals import refused

from wucht.measurements.reading import read_recording
from wucht.measurements.recording import SPEED

T = np.arange(5) * 0.25


def write(path, *sets):
    file = pyuff.UFF(str(path))
    for given in sets:
        told = {
            "binary": 0, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "id1": "NONE", "id2": "NONE",
            "id3": "NONE", "id4": "NONE", "id5": "NONE", "ord_data_type": 4, "abscissa_spacing": 1, "abscissa_min": 0.0,
            "abscissa_inc": 0.25, "abscissa_spec_data_type": 17, "abscissa_axis_units_lab": "s", "ordinate_spec_data_type": 0,
            "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "ordinate_axis_units_lab": "rpm", "num_pts": 5, "x": T,
        }  # fmt: skip
        file.write_sets(pyuff.prepare_58(**{**told, **given}), "add")


def test_time_signals(tmp_path):
    path = tmp_path / "r.uff"
    write(path, {"id1": "speed", "data": T + 60}, {"id1": "force", "data": T - 1, "ordinate_axis_units_lab": "NONE"})
    found = read_recording(path)
    assert found.names == ("speed", "force")
    speed = found.channel("speed", SPEED)
    assert speed.time == pytest.approx(T)
    assert speed.values == pytest.approx((T + 60) * np.pi / 30)
    assert (found.channel("force").unit, found.channel("force").values.tolist()) == ("", (T - 1).tolist())


@pytest.mark.parametrize("binary", [0, 1])
def test_uneven_times_in_another_unit(tmp_path, binary):
    path = tmp_path / "r.unv"
    x = np.array([0.0, 100, 150, 400, 1000])
    write(path, {"id1": "a", "data": x**2, "x": x, "abscissa_spacing": 0, "abscissa_axis_units_lab": "ms", "binary": binary})
    channel = read_recording(path).channel("a")
    assert channel.time == pytest.approx(x / 1000)
    assert channel.values == pytest.approx(x**2)


def test_names_that_are_none_or_twice_the_same(tmp_path):
    path = tmp_path / "r.uff"
    write(path, {"data": T}, {"id1": "x", "data": T}, {"id1": "x", "data": 2 * T}, {"id1": "y", "data": T})
    found = read_recording(path)
    assert found.names == ("1", "2", "3", "y")
    assert found.channel("3").values == pytest.approx(2 * T)


def test_spectra_are_passed_over(tmp_path):
    path = tmp_path / "r.uff"
    write(path, {"func_type": 4, "abscissa_spec_data_type": 18, "data": T * 1j, "ord_data_type": 6})
    with refused("r.uff", "58", code="no-signal"):
        read_recording(path)
    write(path, {"id1": "x", "data": T})
    assert read_recording(path).names == ("x",)
