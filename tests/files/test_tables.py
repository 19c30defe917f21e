"""Files of measured points: how they may be written, and what is reported of those that cannot be used."""

import copy
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.errors import InputError
from wucht.files.tables import SPEED_TORQUE, read_table, with_tables
from wucht.files.text_rows import cells_of, plain_number, separator_of, without_comment

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
        "0,0;5,0\n1e2;8,0\n150,0;0\n",
        "# measured on Monday\nspeed, torque\n0, 5 # standstill\n\n100, 8\n150, 0\n",
        "\ufeffspeed;torque\n0;5\n100;8\n150;0\n",
        "w[rad/s] M[N m]\n0 5\n100 8\n150 0\n",
        "0,0\t5,0\n1e2\t8,0\n150,0\t0\n",
        "speed [rad/s]; torque [Nm];\n0;5;\n100;8;\n150;0;\n",
        "\ufeffDrehzahl in U/min; Moment in Nm\r\n0,0;5\r\n954,9296585513721;8\r\n1432,3944878270580;0\r\n",
    ],
)
def test_the_same_table_in_many_hands(written, text):
    rows = read_table(written(text), SPEED_TORQUE)
    assert [x for row in rows for x in row] == pytest.approx([0, 5, 100, 8, 150, 0], rel=1e-14)


@pytest.mark.parametrize("heading", ["speed (rpm), torque [kN m]", "n / min^-1, M / kNm", "rpm, kNm"])
def test_the_heading_may_carry_units(written, heading):
    rows = read_table(written(f"{heading}\n0, 0.005\n1500, 8e-3\n"), SPEED_TORQUE)
    assert rows == [[0.0, 5.0], [pytest.approx(1500 * RPM), 8.0]]


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


@pytest.mark.parametrize(
    ("line", "separator", "least", "cells"),
    [
        ('"time [s]";"speed [1/min]";;', ";", 1, ["time [s]", "speed [1/min]"]),
        ("5;", ";", 2, ["5", ""]),
        ("time [m s]  speed (1 / min)", None, 1, ["time [m s]", "speed (1 / min)"]),
        ('"a, b", "say ""c"""', ",", 1, ["a, b", 'say "c"']),
        ('"a, 2', ",", 1, ["a", "2"]),
        ('"a", ' + 200_000 * "b", ",", 1, ["a", 200_000 * "b"]),
    ],
)
def test_cells(line: str, separator: str | None, least: int, cells: list[str]) -> None:
    assert cells_of(line, separator, least) == cells


@pytest.mark.parametrize(
    ("line", "separator", "text"),
    [('"a;b",c # d', ",", '"a;b",c'), ('"a #1";b', ";", '"a #1";b'), ('"a #1', None, '"a'), ("# only", None, "")],
)
def test_quoted_cells_neither_separate_nor_begin_a_comment(line: str, separator: str | None, text: str) -> None:
    assert without_comment(line) == text
    assert separator_of(without_comment(line)) == separator


@pytest.mark.parametrize("text", ["٣", "３", "1_0", "1,5", "x"])
def test_numbers_have_the_digits_0_to_9(text: str) -> None:
    assert plain_number("-1.5e2") == -150
    with pytest.raises(ValueError, match=text):
        plain_number(text)
