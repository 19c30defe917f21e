"""What cannot be counted: a sentence each, with the file and the key, and exit code 2."""

import pytest

from wucht.studies.shared_keys import Woehler

RECORD = """\
[study]
kind = "load-spectrum"
signal = { file = "record.csv", column = "force" }
counting = "rainflow"
residue = "repeat"
"""
MACHINE = """\
[machine]
use = "drozdetskaya-2020/r1"
[study]
kind = "load-spectrum"
signal = "displacement"
until = "1 s"
"""
COUNTING, RESIDUE, SIGNAL = 'counting = "rainflow"', 'residue = "repeat"', 'signal = { file = "record.csv", column = "force" }'
LINE = 'woehler = { k = 5, ND = 1e6, SD = "1 kN" }'
CASES = {
    "signal": (RECORD, SIGNAL, 'signal = "stress"', ("study.signal", "'stress'", "'bearing-force'", "a record")),
    "no such file": (RECORD, "record.csv", "recrod.csv", ("recrod.csv", "there is no such file")),
    "ending": (RECORD, "record.csv", "record.dat", ("record.dat", "must end in one of")),
    "column": (RECORD, '"force"', '"froce"', ("record.csv", "'froce'", "did you mean 'force'")),
    "which column": (RECORD, ', column = "force"', "", ("study.signal.column", "force, strain")),
    "key of the record": (RECORD, "column =", "colum =", ("study.signal.colum", "did you mean 'column'")),
    "counting": (RECORD, '"rainflow"', '"rain-flow"', ("study.counting", "'rain-flow'", "'range-pair'")),
    "residue": (RECORD, '"repeat"', '"keep"', ("study.residue", "'keep'", "'half-cycles', 'repeat' or 'drop'")),
    "run-up of a record": (RECORD, COUNTING, 'until = "3 s"', ("study.until", "only allowed for a machine's run-up")),
    "direction of a record": (RECORD, COUNTING, 'direction = "x"', ("study.direction", "only allowed for a machine's run-up")),
    "after the end": (RECORD, COUNTING, 'after = "9 s"', ("study.after", "must be less than", "4 s")),
    "reference": (RECORD, COUNTING, 'reference = "0 N"', ("study.reference", "allowed only with counting = 'level-crossing'")),
    "unit of the reference": (
        RECORD, COUNTING, 'counting = "peaks"\nreference = "0 mm"', ("study.reference", "'0 mm'", "a number in N"),
    ),
    "nothing to drop": (RECORD, f"{COUNTING}\n{RESIDUE}", 'counting = "peaks"\nresidue = "drop"', ("study.residue", "'drop'")),
    "classes": (RECORD, COUNTING, 'class_width = "0 N"', ("study.class_width", "greater than 0")),
    "too many classes": (RECORD, COUNTING, 'class_width = "0.1 mN"', ("study.class_width", "at least 0.0005", "10000 classes")),
    "woehler": (RECORD, COUNTING, "woehler = 5", ("study.woehler", "must be a table", "k = SLOPE")),
    "half a line": (RECORD, COUNTING, "woehler = { k = 5, ND = 1e6 }", ("study.woehler.SD", "missing", "at the knee")),
    "unit of the line": (RECORD, COUNTING, LINE.replace("1 kN", "100 MPa"), ("study.woehler.SD", "'100 MPa'", "a number in N")),
    "slope": (RECORD, COUNTING, LINE.replace("k = 5", "k = -5"), ("study.woehler.k", "greater than 0")),
    "steep slope": (RECORD, COUNTING, LINE.replace("k = 5", "k = 300"), ("study.woehler.k", "at most 100")),
    "rule": (RECORD, COUNTING, LINE.replace("}", ', miner = "corten" }'), ("study.woehler.miner", "'elementary' or 'haibach'")),
    "two rules": (
        RECORD, COUNTING, LINE.replace("}", ', miner = "original", k2 = 9 }'), ("study.woehler.k2", "either k2 or miner"),
    ),
    "no machine": (RECORD, SIGNAL, "", ("study.signal", "a table [machine] is required, or a record")),
    "both": (
        MACHINE, 'signal = "displacement"\nuntil = "1 s"', SIGNAL, ("study.signal", "either a table [machine] or a record"),
    ),
    "direction": (MACHINE, 'until = "1 s"', 'until = "1 s"\ndirection = "r"', ("study.direction", "'r'", "x, y")),
    "model": (MACHINE, 'until = "1 s"', 'until = "1 s"\nmodel = "both"', ("study.model", "'full' or 'slow'")),
    "after until": (MACHINE, 'until = "1 s"', 'until = "1 s"\nafter = "2 s"', ("study.after", "less than study.until")),
    "rotor of a record": (RECORD, COUNTING, 'rotor = "drum"', ("study.rotor", "only allowed for a machine's run-up")),
    "rotor of a displacement": (MACHINE, 'until = "1 s"', 'until = "1 s"\nrotor = "drum"', ("study.rotor", "'bearing-force'")),
    "no such rotor": (MACHINE, '"displacement"', '"bearing-force"\nrotor = "drun"', ("study.rotor", "'drun'", "'drum'")),
    "direction of a bearing": (
        MACHINE, '"displacement"', '"bearing-force"\nrotor = "drum"\ndirection = "r"', ("study.direction", "'r'", "x, y"),
    ),
    "no rotor's force": (
        MACHINE.replace("r1", "table-5.1").replace('"1 s"', "1"), '"displacement"', '"bearing-force"\nrotor = "rotor"',
        ("study.rotor", "newtons"),
    ),
    "unknown": (MACHINE, "until =", "untill =", ("study.untill", "did you mean 'until'")),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_what_cannot_be_is_a_sentence(refused, here, case):
    text, old, new, says = CASES[case]
    assert old in text
    (here / "record.csv").write_text("time [s],force [N],strain\n0,-2,1\n1,1,2\n2,-3,1\n3,2,3\n4,-1,0\n", encoding="utf-8")
    (here / "spectrum.toml").write_text(text.replace(old, new), encoding="utf-8")
    refused("run", "spectrum.toml", says=("spectrum.toml", *says))


def test_a_record_has_no_machine_to_set(refused, here):
    (here / "record.csv").write_text("0,1\n1,2\n2,0\n", encoding="utf-8")
    (here / "spectrum.toml").write_text(RECORD.replace(', column = "force"', ""), encoding="utf-8")
    refused("run", "spectrum.toml", "--set", "carrier.stiffness=3", says=("carrier.stiffness", "no table [machine]"))


def test_a_cycle_of_the_woehler_line_is_one() -> None:
    """In the words of units a cycle is 2 pi."""
    assert Woehler(k=5, ND="2e6 cycles", SD="1 kN").ND == 2e6


@pytest.mark.usefixtures("no_figures")
def test_a_damage_that_is_no_number_is_a_failed_run(wucht, here):
    (here / "record.csv").write_text("time [s],force [N],strain\n0,-2,1\n1,1,2\n2,-3,1\n3,2,3\n4,-1,0\n", encoding="utf-8")
    line = LINE.replace("k = 5", "k = 100").replace("1 kN", "1 nN")
    (here / "spectrum.toml").write_text(RECORD.replace(COUNTING, f"{COUNTING}\n{line}"), encoding="utf-8")
    done = wucht("run", "spectrum.toml", "-o", "out", "--json")
    assert done.code == done.document["exit_code"] == 1
    assert "wucht: the damage is too large for a number: the largest amplitude is 2.5e+09 times study.woehler.SD" in done.err
    assert done.document["summary"]["damage"] is None and done.document["summary"]["cycles"] > 0
