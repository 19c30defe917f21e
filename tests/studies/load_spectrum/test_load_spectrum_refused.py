"""What cannot be counted: a sentence each, with the file and the key, and exit code 2."""

import pytest
from tests.refusals import cases_of, check_file

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
RECORD_CHANGES = {
    SIGNAL: ['signal = "stress"', ""], "record.csv": ["recrod.csv", "record.dat"], '"force"': ['"froce"'],
    ', column = "force"': [""], "column =": ["colum ="], '"rainflow"': ['"rain-flow"'], '"repeat"': ['"keep"'],
    COUNTING: [
        'until = "3 s"', 'direction = "x"', 'after = "9 s"', 'reference = "0 N"', 'counting = "peaks"\nreference = "0 mm"',
        "woehler = 5", "woehler = { k = 5, ND = 1e6 }",
        'woehler = { k = 5, ND = 1e6, SD = "100 MPa" }', 'woehler = { k = -5, ND = 1e6, SD = "1 kN" }',
        'woehler = { k = 300, ND = 1e6, SD = "1 kN" }', 'woehler = { k = 5, ND = 1e6, SD = "1 kN" , miner = "corten" }',
        'woehler = { k = 5, ND = 1e6, SD = "1 kN" , miner = "original", k2 = 9 }', 'rotor = "drum"',
    ],
    f'{COUNTING}\nresidue = "repeat"': ['counting = "peaks"\nresidue = "drop"'],
}  # fmt: skip
MACHINE_CHANGES = {
    'signal = "displacement"\nuntil = "1 s"': [SIGNAL],
    'until = "1 s"': [
        'until = "1 s"\ndirection = "r"', 'until = "1 s"\nmodel = "both"', 'until = "1 s"\nafter = "2 s"',
        'until = "1 s"\nrotor = "drum"',
    ],
    '"displacement"': ['"bearing-force"\nrotor = "drun"', '"bearing-force"\nrotor = "drum"\ndirection = "r"'],
    "until =": ["untill ="],
}  # fmt: skip
NUMBERS = MACHINE.replace("r1", "table-5.1").replace('"1 s"', "1")
FILES = {"record": (RECORD, RECORD_CHANGES), "machine": (MACHINE, MACHINE_CHANGES),
         "numbers": (NUMBERS, {'"displacement"': ['"bearing-force"\nrotor = "rotor"']})}  # fmt: skip


@pytest.mark.parametrize(("name", "old", "new"), [(name, *c.values) for name, (_, t) in FILES.items() for c in cases_of(t)])
def test_what_cannot_be_is_a_sentence(here, name, old, new):
    (here / "record.csv").write_text("time [s],force [N],strain\n0,-2,1\n1,1,2\n2,-3,1\n3,2,3\n4,-1,0\n", encoding="utf-8")
    check_file(f"load-spectrum, {name}", FILES[name][0], {old: new})


def test_a_record_has_no_machine_to_set(here):
    (here / "record.csv").write_text("0,1\n1,2\n2,0\n", encoding="utf-8")
    check_file("load-spectrum, record", RECORD, {', column = "force"': ""}, {"carrier.stiffness": 3.0})


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
