"""Which file is read how: text, sound, universal, TDMS and MDF files."""

import importlib
import os
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.io import wavfile
from tests.refusals import refused

from wucht.measurements.reading import _check_within_record, read_recording, read_sound
from wucht.measurements.recording import SPEED_UNIT


@pytest.mark.parametrize("ending", ["csv", "TXT", "tsv", "asc"])
def test_text(tmp_path, ending):
    path = tmp_path / f"r.{ending}"
    path.write_text("0 1\n1 2\n")
    assert read_recording(path).channel("2").values.tolist() == [1, 2]


def test_an_unknown_ending(tmp_path):
    with refused("", code="unknown-ending", file="r.xlsx"):
        read_recording(tmp_path / "r.xlsx")


@pytest.mark.parametrize("ending", [".csv", ".wav", ".uff", ".tdms", ".mf4"])
def test_no_file(tmp_path, ending):
    with refused("", code="no-file", file=f"none{ending}"):
        read_recording(tmp_path / f"none{ending}")
    (tmp_path / f"folder{ending}").mkdir()
    with refused("", "folder", code="no-file", file=f"folder{ending}"):
        read_recording(tmp_path / f"folder{ending}")
    os.mkfifo(tmp_path / f"pipe{ending}")
    with refused("", "pipe", code="no-file", file=f"pipe{ending}"):
        read_recording(tmp_path / f"pipe{ending}")


def test_of_thousands_of_columns_some_are_named(tmp_path):
    path = tmp_path / "r.csv"
    names = [f"c{k}" for k in range(20_000)]
    path.write_text("\n".join(",".join(row) for row in (["time", *names], ["0"] * 20_001, ["1"] * 20_001)))
    with refused("r.csv", "19800", given="force") as caught:
        read_recording(path).channel("force")
    assert len(str(caught.value)) < 2500


@pytest.mark.parametrize(
    ("ending", "refusal"),
    [
        (".wav", refused("r.wav", code="unreadable")),
        (".tdms", refused("r.tdms", "TDMS", code="unreadable")),
        (".mf4", refused("r.mf4", "MDF", code="unreadable")),
    ],
)
def test_a_file_of_another_kind(tmp_path, ending, refusal):
    path = tmp_path / f"r{ending}"
    path.write_text("    -1\n    58\nthis is something else\n")
    with refusal:
        read_recording(path)


def test_a_universal_file_of_nothing(tmp_path):
    path = tmp_path / "r.uff"
    path.write_text("this is something else\n")
    with refused("r.uff", code="no-signal"):
        read_recording(path)
    path.write_text("    -1\n    58\nthis is something else\n    -1\n")
    with refused("r.uff", code="unreadable"):
        read_recording(path)


@pytest.mark.parametrize("ending", [".uff", ".tdms", ".mf4"])
def test_a_library_that_is_not_there(tmp_path, monkeypatch, ending):
    path = tmp_path / f"r{ending}"
    path.write_text("")

    def none(name):
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", none)
    with refused(f"r{ending}", "wucht[measure]", given=None):
        read_recording(path)


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
        channel.to_si(SPEED_UNIT)
    assert channel.with_scale(1000, "rpm").to_si(SPEED_UNIT).values == pytest.approx([10.472, 20.944], rel=1e-4)


def test_it_has_samples(tmp_path):
    path = tmp_path / "r.wav"
    wavfile.write(path, 1000, np.array([], np.int16))
    with refused("r.wav", "record or copy it again", code="no-samples"):
        read_sound(path)
    path.write_bytes(b"")
    with refused("r.wav", "empty", "copy it again", code="no-samples"):
        read_sound(path)


@pytest.mark.parametrize("channels", [1, 2])
def test_a_sound_cut_short_is_refused_with_its_samples(tmp_path, channels):
    """As many as its header states, and as there are; a header that states no length is that of a stream."""
    path = tmp_path / "r.wav"
    wavfile.write(path, 1000, np.arange(200 * channels, dtype=np.int16).reshape(200, channels))
    whole = path.read_bytes()
    start = len(whole) - 2 * 200 * channels
    for rest in (1, 2 * channels * 50, 2 * channels * 50 + 1):
        path.write_bytes(whole[:-rest])
        left = 200 - -(-rest // (2 * channels))
        with refused("r.wav", "200 samples", f"there are {left}", "copy it again", code="cut-short"):
            read_sound(path)
    for header in (start, start - 6, 20):
        path.write_bytes(whole[:header])
        with refused("r.wav", "no sample", "copy it again", code="no-samples"):
            read_sound(path)
    path.write_bytes(whole[: start - 4] + b"\xff" * 4 + whole[start:])
    assert len(read_sound(path).channel("1").values) == 200


T = np.arange(5) * 0.25


def write(path, *sets):
    import pyuff

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
    speed = found.channel("speed", SPEED_UNIT)
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


VALUES = np.array([60.0, 90, 120])


def write_tdms(path, *channels):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(path)) as writer:
        writer.write_segment([ChannelObject(group, name, values, properties=told) for group, name, values, told in channels])


def test_a_waveform(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, ("g", "speed", VALUES, {"wf_increment": 0.1, "wf_start_offset": 1.0, "unit_string": "rpm"}))
    found = read_recording(path)
    assert found.names == ("speed",)
    speed = found.channel("speed", SPEED_UNIT)
    assert speed.time == pytest.approx([1, 1.1, 1.2])
    assert speed.values == pytest.approx(VALUES * np.pi / 30)


def test_a_channel_of_times(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, ("g", "Time", np.array([0, 5, 20]), {"unit_string": "ms"}), ("g", "x", VALUES.astype(np.int16), {}))
    channel = read_recording(path).channel("x")
    assert (channel.time.tolist(), channel.values.tolist(), channel.unit) == ([0, 0.005, 0.02], [60, 90, 120], "")


def test_groups_with_channels_of_one_name(tmp_path):
    path = tmp_path / "r.tdms"
    told = {"wf_increment": 0.1}
    write_tdms(path, ("a", "x", VALUES, told), ("b", "x", 2 * VALUES, told), ("b", "y", VALUES, told))
    found = read_recording(path)
    assert found.names == ("a/x", "b/x", "y")
    assert found.channel("b/x").values.tolist() == [120, 180, 240]


def test_a_channel_without_time(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, ("g", "x", VALUES, {}))
    with refused("r.tdms: x", code="no-time"):
        read_recording(path).channel("x")


def test_text_is_no_channel_of_numbers(tmp_path):
    path = tmp_path / "r.tdms"
    write_tdms(path, ("g", "x", ["a", "b", "c"], {"wf_increment": 0.1}), ("g", "y", VALUES, {"wf_increment": 0.1}))
    with refused("r.tdms: x", code="no-numbers"):
        read_recording(path).channel("x")
    assert read_recording(path).channel("y").values.tolist() == VALUES.tolist(), "it does not hinder the others"


def test_what_is_no_tdms(tmp_path):
    path = tmp_path / "bad.tdms"
    path.write_text("hello")
    with refused("bad.tdms", "TDMS", code="unreadable"):
        read_recording(path)


SLOW, FAST = np.array([0.5, 0.6, 0.9]), np.arange(6) / 20


def write_mdf(path, *groups):
    from asammdf import MDF, Signal

    with MDF() as file:
        for signals in groups:
            file.append([Signal(np.asarray(v), timestamps=t, name=n, unit=u, encoding="utf-8") for n, t, v, u in signals])
        return file.save(path, overwrite=True)


def test_channels_each_over_its_own_time(tmp_path):
    path = tmp_path / "r.mf4"
    write_mdf(path, [("speed", SLOW, [60.0, 90, 120], "rpm")], [("x", FAST, FAST**2, ""), ("n", FAST, np.arange(6), "")])
    found = read_recording(path)
    assert sorted(found.names) == ["n", "speed", "x"]
    speed = found.channel("speed", SPEED_UNIT)
    assert speed.time.tolist() == SLOW.tolist()
    assert speed.values == pytest.approx(np.array([60, 90, 120]) * np.pi / 30)
    assert found.channel("x").values.tolist() == (FAST**2).tolist()
    assert found.channel("n").time.tolist() == FAST.tolist()


def test_groups_of_mdf_with_channels_of_one_name(tmp_path):
    path = tmp_path / "r.mf4"
    write_mdf(path, [("x", SLOW, [1.0, 2, 3], "")], [("x", SLOW, [4.0, 5, 6], "")])
    found = read_recording(path)
    assert found.names == ("0/x", "1/x")
    assert found.channel("1/x").values.tolist() == [4, 5, 6]


def test_text_is_no_channel_of_numbers_in_mdf(tmp_path):
    path = tmp_path / "r.mf4"
    write_mdf(path, [("state", SLOW, np.array([b"on", b"off", b"on"]), ""), ("x", SLOW, [1.0, 2, 3], "")])
    with refused("r.mf4: state", code="no-numbers"):
        read_recording(path).channel("state")


def test_a_channel_beyond_its_record_is_not_read() -> None:
    """In a damaged MDF file; 64 bits from the byte 8 of a record of 16 bytes on are its last."""

    def group(offset: int, bits: int, **size: int) -> Any:
        clock = SimpleNamespace(name="time", byte_offset=0, bit_count=64)
        return SimpleNamespace(
            channel_group=SimpleNamespace(**size),
            channels=[clock, SimpleNamespace(name="force", byte_offset=offset, bit_count=bits)],
        )

    for offset, bits in ((8, 64), (15, 8), (500, 0)):
        _check_within_record(group(offset, bits, samples_byte_nr=16), (1, 0))
    _check_within_record(group(500, 64), (1, 0))
    for offset, bits in ((9, 64), (8, 65), (16, 1)):
        with pytest.raises(ValueError, match="force lies beyond its record"):
            _check_within_record(group(offset, bits, samples_byte_nr=16), (0, 1))
