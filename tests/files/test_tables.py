"""Files of measured points: how they may be written, and what is reported of those that cannot be used."""

import copy
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import refused

from wucht.errors import InputError
from wucht.files.tables import SPEED_TORQUE, read_table, with_tables

many = settings(max_examples=200, deadline=None)
RPM = math.pi / 30


@pytest.fixture
def written(tmp_path):
    """A file with a text in it."""

    def write(text, name="motor.csv"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


@pytest.mark.parametrize(
    "text",
    [
        "0,5\n100,8\n150,0\n",
        "0, 5\r\n100, 8\r\n150, 0",
        "0;5\n100;8\n150;0\n",
        "0,0;5,0\n1e2;8,0\n150,0;0\n",
        "0 5\n100\t8\n  150   0  \n\n",
        "# measured on Monday\nspeed, torque\n0, 5 # standstill\n\n100, 8\n150, 0\n",
        "\ufeffspeed;torque\n0;5\n100;8\n150;0\n",
        "speed [rad/s], torque [N m]\n0, 5\n100, 8\n150, 0\n",
        "speed (rad/s) torque (N m)\n0 5\n100 8\n150 0\n",
        "w[rad/s] M[N m]\n0 5\n100 8\n150 0\n",
        '"speed of the shaft (rad/s)","torque [N m/(rad/s) * rad/s]"\n"0","5"\n"100","8"\n"150","0"\n',
        "speed [rad/s]; torque [Nm];\n0;5;\n100;8;\n150;0;\n",
        "0,0\t5,0\n1e2\t8,0\n150,0\t0\n",
        "\ufeffDrehzahl in U/min; Moment in Nm\r\n0,0;5\r\n954,9296585513721;8\r\n1432,3944878270580;0\r\n",
        "n in rpm\tM in kNm\n0\t0,005\n954,9296585513721\t0,008\n1432,3944878270580\t0\n",
        "speed [deg/s]; torque [N mm]\n0; 5000\n5729,5779513082321; 8e3\n8594.366926962348; 0\n",
    ],
)
def test_the_same_table_in_many_hands(written, text):
    rows = read_table(written(text), SPEED_TORQUE)
    assert [x for row in rows for x in row] == pytest.approx([0, 5, 100, 8, 150, 0], rel=1e-14)


@pytest.mark.parametrize(
    "heading",
    [
        "speed (rpm), torque [kN m]",
        "n in 1/min, M in kNm",
        "n 1/min, M kN m",
        "n / min^-1, M / kNm",
        "rpm, kNm",
        "n RPM, M kN*m",
    ],
)
def test_the_heading_may_carry_units(written, heading):
    rows = read_table(written(f"{heading}\n0, 0.005\n1500, 8e-3\n"), SPEED_TORQUE)
    assert rows == [[0.0, 5.0], [pytest.approx(1500 * RPM), 8.0]]


@pytest.mark.parametrize(
    ("text", "refusal"),
    [
        ("", refused("", "0", code="too-few", file="motor.csv")),
        ("speed, torque\n1, 2\n", refused("", "1", code="too-few", file="motor.csv")),
        ("1, 2\n3, 4\n5, six\n", refused("", "line 3", "six", "torque", code="no-number", file="motor.csv")),
        ("1, 2\nspeed, torque\n", refused("", "line 2", "'speed'", code="no-number", file="motor.csv")),
        ("1, 2\n3, nan\n", refused("", "line 2", "nan", code="no-number", file="motor.csv")),
        ("1, 2\n٣, 4\n", refused("", "line 2", "٣", "digits 0 to 9", code="no-number", file="motor.csv")),
        ("nan, inf\n3, 4\n", refused("", "line 1", "nan", code="no-number", file="motor.csv")),
        ("1, 2\n3, 1e999\n", refused("", "line 2", "1e999", code="no-number", file="motor.csv")),
        ("1, 2\n3, 1_0\n", refused("", "line 2", "1_0", code="no-number", file="motor.csv")),
        ("1, 2\n\n# again\n1, 3\n", refused("", "line 4", "speed", code="not-increasing", file="motor.csv")),
        ("1, 2\n3, 4, 5\n", refused("", "line 2", "3 columns", code="count", file="motor.csv")),
        ("1\n2\n", refused("", "line 1", "1 columns", code="count", file="motor.csv")),
        ("1,5 2,5\n2,5 3,5\n", refused("", "line 1", "3 columns", "semicolon", code="count", file="motor.csv")),
        ("1,5,2,5\n2,5,3,5\n", refused("", "line 1", "4 columns", "semicolon", code="count", file="motor.csv")),
        ("n in hurz; M in Nm\n1;2\n3;4\n", refused("", "line 1", "hurz", code="unknown-unit", file="motor.csv")),
        (
            "n; M\nU/min; Nm\n1; 2\n2; 3\n",
            refused("", "line 2", "U/min", "speed [rad/s]; torque [N m]", code="heading-twice", file="motor.csv"),
        ),
        ("speed, torque, power\n1, 2\n3, 4\n", refused("", "line 1", "heading has 3", code="count", file="motor.csv")),
        ("speed (V), torque\n1, 2\n3, 4\n", refused("", "line 1", "voltage", code="dimension", file="motor.csv")),
        ("speed (hurz), torque\n1, 2\n3, 4\n", refused("", "line 1", "hurz", code="unknown-unit", file="motor.csv")),
        ("speed (1/s), torque\n1, 2\n3, 4\n", refused("", "line 1", "speed", code="no-quantity", file="motor.csv")),
        ("torque, speed\n1, 2\n3, 4\n", refused("", "line 1", code="exchanged", file="motor.csv")),
        ("speed (rpm, torque\n1, 2\n3, 4\n", refused("", "line 1", "speed (rpm", code="no-heading", file="motor.csv")),
        (b"\xff\xfe1\x00", refused("", "UTF", code="unreadable", file="motor.csv")),
    ],
)
def test_a_bad_table_is_refused_with_its_line(written, text, refusal):
    path = written(text)
    with refusal as error:
        read_table(path, SPEED_TORQUE)
    assert error.value.location == str(path)


def test_a_file_that_cannot_be_read(tmp_path):
    for path, sentence in ((tmp_path / "none.csv", "there is no such file"), (tmp_path, "cannot be read: Is a directory")):
        with pytest.raises(InputError, match=sentence):
            read_table(path, SPEED_TORQUE)


@many
@given(st.text(alphabet='0123456789.,;-+eE #[]()ab_\n\t"', max_size=60))
def test_any_text_gives_a_table_or_a_sentence(tmp_path_factory, text):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_text(text, encoding="utf-8")
    try:
        rows = read_table(path, SPEED_TORQUE)
    except InputError:
        return
    assert len(rows) >= 2
    assert all(len(r) == 2 and all(math.isfinite(x) for x in r) for r in rows)


MACHINE = {
    "carrier": {"mass": 1.0, "motion": {"direction": "x", "table": "motion.csv"}},
    "drives": [{"on": "a", "kind": "linear", "slope": 1}, {"on": "b", "kind": "table", "file": "motor.csv"}],
    "loads": [{"on": "a", "kind": "table", "file": "sub/fan.csv"}],
}


def test_files_become_points(tmp_path, written):
    written("0, 5\n100, 8\n")
    written("time [ms], x [mm]\n0, 1\n10, 2\n", "motion.csv")
    (tmp_path / "sub").mkdir()
    written("0, 0\n100, 2\n", "sub/fan.csv")
    before = copy.deepcopy(MACHINE)
    document = with_tables(MACHINE, tmp_path)
    assert before == MACHINE
    assert document["drives"] == [MACHINE["drives"][0], {"on": "b", "kind": "table", "points": [[0, 5], [100, 8]]}]
    assert document["loads"] == [{"on": "a", "kind": "table", "points": [[0, 0], [100, 2]]}]
    assert document["carrier"] == {
        "mass": 1.0,
        "motion": {"direction": "x", "points": [[0, 1e-3], [pytest.approx(1e-2), 2e-3]]},
    }
    assert with_tables({"drive": MACHINE["drives"][1]}, tmp_path)["drive"]["points"] == [[0, 5], [100, 8]]


def test_a_carrier_that_turns_is_moved_by_an_angle(tmp_path, written):
    written("time [s], angle [deg]\n0, 0\n1, 180\n", "motion.csv")
    for carrier in (
        {"directions": "r", "motion": {"table": "motion.csv"}},
        {"motion": {"direction": "r", "table": "motion.csv"}},
    ):
        document = with_tables({"carrier": carrier}, tmp_path)
        assert document["carrier"]["motion"]["points"] == [[0, 0], [1, pytest.approx(math.pi)]]


@pytest.mark.parametrize(
    ("machine", "refusal"),
    [
        ({"drive": {"kind": "table", "file": "none.csv"}}, refused("machine.drive.file", given="none.csv", code="no-file")),
        (
            {"drive": {"kind": "table", "file": "bad.csv"}},
            refused("machine.drive.file", "line 2", "'x'", given="bad.csv", code="no-number"),
        ),
        (
            {"drives": [{}, {"kind": "table", "file": 3}]},
            refused("machine.drives[1].file", given=3),
        ),
        ({"loads": [{"kind": "table", "file": " "}]}, refused("machine.loads[0].file", given=" ")),
        (
            {"drive": {"kind": "table", "file": "bad.csv", "points": [[0, 1], [1, 2]]}},
            refused("machine.drive.file", "points", given="bad.csv", code="either-or"),
        ),
        (
            {"carrier": {"motion": {"table": "bad.csv"}}},
            refused("machine.carrier.motion.table", "line 2", "'x'", given="bad.csv", code="no-number"),
        ),
    ],
)
def test_errors_name_the_key(written, machine, refusal):
    folder = written("1, 2\n3, x\n", "bad.csv").parent
    with refusal:
        with_tables(machine, folder)


@pytest.mark.parametrize(
    "machine",
    [{}, {"drive": 3}, {"drives": "x", "loads": [7]}, {"carrier": {"motion": "x"}}, {"drive": {"kind": "linear", "file": "x"}}],
)
def test_what_is_no_table_is_left_to_the_machine(tmp_path, machine):
    assert with_tables(machine, tmp_path) == machine
