"""Which file is read how: text, sound, universal, TDMS and MDF files."""

import importlib
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import wavfile
from tests.refusals import refused

from wucht.measurements.reading import read_recording, read_sound
from wucht.measurements.recording import SPEED_UNIT
from wucht.measurements.text_file import read_text_file


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
    for own in sets:
        told = {
            "binary": 0, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "id1": "NONE", "id2": "NONE",
            "id3": "NONE", "id4": "NONE", "id5": "NONE", "ord_data_type": 4, "abscissa_spacing": 1, "abscissa_min": 0.0,
            "abscissa_inc": 0.25, "abscissa_spec_data_type": 17, "abscissa_axis_units_lab": "s", "ordinate_spec_data_type": 0,
            "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "ordinate_axis_units_lab": "rpm", "num_pts": 5, "x": T,
        }  # fmt: skip
        file.write_sets(pyuff.prepare_58(**{**told, **own}), "add")


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


@pytest.fixture
def read(tmp_path):
    def of(text, encoding="utf-8"):
        path = tmp_path / "r.csv"
        path.write_bytes(text.encode(encoding))
        return read_text_file(path)

    return of


@pytest.mark.parametrize(
    "text",
    [
        "time [ms], speed (rpm)\n0, 60\n500, 120.5\n",
        "time (ms);speed [rpm]\n0;60\n500;120,5\n",
        "time [ms]\tspeed [rpm]\n0\t60\n500\t120,5\n",
        "# a record\n\ntime [ms], speed [rpm]\n0, 60 # begins\n\n500, 120.5\n",
        "time;speed\nms;rpm\n0;60\n500;120,5\n",
        "speed [rpm], time [ms]\n60, 0\n120.5, 500\n",
        "\ufefftime [ms],speed [rpm]\r\n0,60\r\n5e2,1.205e2\r\n",
        '"time [ms]", "speed\n[rpm]"\n"0", "60"\n"500", "120.5"\n',
    ],
)
def test_one_record_in_many_ways(read, text):
    speed = read(text).channel("speed")
    assert (speed.unit, speed.time.tolist(), speed.values.tolist()) == ("rpm", [0, 0.5], [60, 120.5])
    assert read(text).names == ("speed",)


def test_quoted_cells_hold_what_separates_elsewhere(read):
    text = '"time, relative [s]","force, left [N]","say ""#1""" # a comment\n0,1,"2"\n"1",4,5 # another\n'
    found = read(text)
    assert found.names == ("force, left", 'say "#1"')
    assert found.channel("force, left").unit == "N"
    assert found.channel('say "#1"').values.tolist() == [2, 5]


@pytest.mark.parametrize(("encoding", "mark"), [("utf-16-le", "\ufeff"), ("utf-16-be", "\ufeff"), ("utf-32-le", "\ufeff")])
def test_other_widths_of_letters_are_read_by_their_mark(read, encoding, mark):
    found = read(mark + "Zeit [ms];Kraft µ [N]\r\n0;1\r\n500;-2,5\r\n", encoding).channel("Kraft µ")
    assert (found.unit, found.time.tolist(), found.values.tolist()) == ("N", [0, 0.5], [1, -2.5])


def test_wide_letters_without_a_mark_are_refused_with_a_remedy(read, tmp_path):
    for encoding in ("utf-16-le", "utf-16-be", "utf-32-be"):
        with refused("r.csv", "line 1", "UTF-8", code="unreadable"):
            read("time,force\n0,1\n1,2\n", encoding)
    (tmp_path / "cut.csv").write_bytes("time,force\n0,1\n1,2\n".encode("utf-16")[:-1])
    with refused("cut.csv", "UTF-16", "cut short", "UTF-8", code="unreadable"):
        read_text_file(tmp_path / "cut.csv")


@pytest.mark.parametrize(
    "text",
    [
        "Zeit [s];Drehzahl [U/min]\n0;60\n0,5;120\n",
        "Zeit in ms;Drehzahl in 1/min\n0;60\n500;120\n",
        "Zeit;Drehzahl\n[ms];[min-1]\n0;60\n500;120\n",
        "Zeit;Drehzahl\ns;RPM\n0;60\n0,5;120\n",
    ],
)
def test_german_loggers(read, text):
    (name,) = read(text).names
    speed = read(text).channel(name, SPEED_UNIT)
    assert name.startswith("Drehzahl")
    assert speed.time.tolist() == [0, 0.5]
    assert speed.values == pytest.approx([2 * np.pi, 4 * np.pi])


def test_the_first_column_is_the_time_if_none_is_called_so(read):
    found = read("clock [ms], x\n0, 1\n2, 3\n")
    assert found.names == ("x",)
    assert found.channel("x").time.tolist() == [0, 0.002]
    with refused("r.csv: speed", given="rpm", code="dimension"):
        read("speed [rpm], x\n0, 1\n2, 3\n")


def test_a_lone_column_holds_instants(read):
    pulses = read("pulses [ms]\n1\n3\n4\n").channel("pulses")
    assert (pulses.unit, pulses.time.tolist(), pulses.values.tolist()) == ("s", [0.001, 0.003, 0.004], [0.001, 0.003, 0.004])
    assert read("1.5\n2.5\n").channel("1").values.tolist() == [1.5, 2.5]


def test_other_letters_than_utf_8(read):
    assert read("time [µs];angle [°]\n0;1\n1000;2\n", "latin-1").channel("angle").time.tolist() == [0, 0.001]


@pytest.mark.parametrize(
    ("text", "refusal"),
    [
        ("time, speed\n", refused("r.csv", "no row", given=None, code="no-rows")),
        ("time, speed\n0, 1\n1, x\n", refused("r.csv: speed", "line 3", "x", code="no-number")),
        ("time, speed\n0, 1\n1, -inf\n", refused("r.csv: speed", "line 3", "-inf", code="no-number")),
        ("time, speed\n0, 1\n1,\n", refused("r.csv: speed", "line 3", code="no-value")),
        (
            "time; n; index\n0;1;2\n1;1;2\n\n2;3;\n3;3;\n4;3;\n",
            refused("r.csv: index", "2 values", "line 5", code="ends-early"),
        ),
        ("time, n\n0, 1\n1\n", refused("r.csv", "line 3", "2 columns", code="count")),
        ("time, speed\n0, 1, 2\n1, 2, 3\n", refused("r.csv", "line 2", "3 columns", "2", given=None, code="no-heading")),
        ("time, x, x\n0, 1, 2\n1, 2, 3\n", refused("r.csv", "x", given=None, code="name-twice")),
        ("time; speed\n0,5; 1\n0,5; 2\n", refused("r.csv: speed", "0.5 s", given=None, code="not-increasing")),
        ("time, speed\n0, 1\n", refused("r.csv: time", given=None, code="too-few")),
        ("0,5 1,5\n1,5 2,5\n", refused("r.csv: 2", "line 1", "5 1", code="no-number")),
        ("t,x\n٠,١\n١,٢\n", refused("r.csv: t", "line 2", "٠", "digits 0 to 9", code="no-number")),
        ("t,x\n0,1_000\n1,2\n", refused("r.csv: x", "line 2", "1_000", "underscores", code="no-number")),
        ('t,x\n0,"1,000.5"\n1,"2"\n', refused("r.csv: x", "line 2", "1,000.5", "decimal point", code="no-number")),
        ('"t","x"\n"0,0","1,5"\n"0,5","2,5"\n', refused("r.csv: t", "line 2", "0,0", "decimal point", code="no-number")),
        ("t;x\n0;1.000,5\n1;2\n", refused("r.csv: x", "line 2", "1.000,5", "thousands", code="no-number")),
        ("'t','x'\n'0','1'\n'1','2'\n", refused("r.csv: 't'", "line 2", "apostrophes", code="no-number")),
        ('"t","x"\n"0","1"\n"1","2\n"2","3"\n', refused("r.csv", "line 3", "quotation mark", code="open-quotes")),
        ('"t","x\n"0","1"\n"1","2"\n', refused("r.csv", "line 1", "quotation mark", code="open-quotes")),
    ],
)
def test_what_cannot_be_read(read, text, refusal):
    with refusal:
        found = read(text)
        [found.channel(n) for n in found.names]


@given(
    values=st.lists(st.floats(-1e30, 1e30), min_size=2, max_size=20),
    separator=st.sampled_from(",;\t "),
)
def test_what_is_written_is_read(tmp_path_factory, values, separator):
    path = tmp_path_factory.mktemp("text") / "r.txt"
    rows = [f"{i}{separator}{v!r}" for i, v in enumerate(values)]
    path.write_text("\n".join([f"time{separator}x", *rows]))
    assert read_text_file(path).channel("x").values.tolist() == values


def test_a_library_that_is_not_there(tmp_path, monkeypatch):
    path = tmp_path / "r.uff"
    path.write_text("")

    def none(name):
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", none)
    with refused("r.uff", "wucht[measure]", given=None):
        read_recording(path)


def test_words_that_are_no_unit(read):
    assert read("t;tilt in plane\n0;1\n1;2\n").channel("tilt in plane").unit == ""
    assert read("t;a in g\n0;1\n1;2\n").channel("a in g").unit == "g"


def test_a_channel_beyond_its_record_is_not_read(tmp_path):
    """In a damaged file: its first byte, after so many links, is put behind the end of a record."""
    from asammdf import MDF

    path = write_mdf(tmp_path / "r.mf4", [("force", SLOW, [1.0, 2, 3], "")])
    with MDF(path) as file:
        channel = file.groups[0].channels[1]
        place = channel.address + 24 + 8 * channel.links_nr + 4
        assert channel.byte_offset == 8
    whole = bytearray(path.read_bytes())
    assert whole[place] == 8
    whole[place] = 9
    path.write_bytes(whole)
    with refused("r.mf4", "MDF", "force", code="unreadable"):
        read_recording(path).channel("force")
