"""Text files in the many ways in which they are written."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.refusals import refused

from wucht.measurements.recording import SPEED_UNIT
from wucht.measurements.text_file import read_text_file


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
