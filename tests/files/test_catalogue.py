"""Every catalogue file loads, its equations derive and can be evaluated at its start."""

from pathlib import Path

import numpy as np
import pytest
from tests.refusals import refused

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.errors import InputError
from wucht.files.catalogue import FOLDER, load_equations, load_machine, names, nearest_names
from wucht.files.documents import read_toml
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.studies.study_file import read_study


def test_the_names_of_the_contract_are_there():
    assert {f"drozdetskaya-2020/{n}" for n in ("table-3.1-carrier", "table-3.1-laval", "table-5.1", "table-a.1")} <= set(
        names()
    )


CAMS = [name for name in names() if "law" in read_toml(FOLDER / f"{name}.toml")]


@pytest.mark.parametrize("name", CAMS)
def test_every_cam(name):
    drive = read_study(name).subject
    assert drive.make_cams(drive.motion_law.function)


OWN = [name for name in names() if "system" in read_toml(FOLDER / f"{name}.toml")]


@pytest.mark.parametrize("name", OWN)
def test_every_system(name):
    own = load_equations(name)
    run = integrate(compile_system(own.system), [0.3, 0.2], own.values, np.linspace(0, 0.01, 3))
    assert run.failure is None
    assert read_study(name).subject.system == own.system


# The same machines with more or fewer balls, or at another speed, which tests/test_practice_runs.py runs.
VARIED = tuple(
    f"practice/{n}"
    for n in (
        "angle-grinder", "balls-at-resonance", "balls-at-resonance-thick-oil", "fan-ball-ring", "grinder-10-balls",
        "grinder-4-balls", "grinder-6-balls", "laundry-drum-tumbling",
    )
)  # fmt: skip


@pytest.mark.parametrize("name", VARIED)
def test_a_machine_like_another_is_read(name):
    machine = read_study(name).subject
    assert read_toml(FOLDER / f"{name}.toml")["title"].startswith(machine.title)
    assert machine.tracks


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n in VARIED else n for n in sorted({*names()} - {*CAMS, *OWN})],
)
def test_every_machine(name):
    study = read_study(name)
    machine = study.subject
    system = machine.system
    assert set(system.parameter_names) == set(machine.values) - {s.parameter for s in machine.schedules}
    mass = system.second_order.mass
    assert (mass - mass.T).expand().is_zero_matrix
    initial = initial_state(machine, getattr(study.spec, "start", {}))
    run = integrate(compile_system(system), initial, machine.values, np.linspace(0, 0.01, 3))
    assert run.failure is None
    assert np.isfinite(run.end_state).all()
    outputs = compile_system(system).outputs(run.time, run.states, run.final_parameter_values)
    assert all(np.isfinite(v).all() for v in outputs.values())


@pytest.mark.parametrize("name", names())
def test_every_entry_says_what_it_is_and_where_it_comes_from(name):
    document = read_toml(FOLDER / f"{name}.toml")
    assert document["title"]
    assert document["source"]


def test_values_are_set_by_path():
    assert load_machine("drozdetskaya-2020/table-5.1", {"u": 1.5}).values["u"] == 1.5
    assert load_machine("drozdetskaya-2020/r1", {"drum.eccentricity": "2 mm", "drum.inertia": 1e-3}).values[
        "drum.eccentricity"
    ] == pytest.approx(2e-3)


def test_entries_that_use_another_differ_only_where_they_say():
    r1, r2 = (load_machine(f"drozdetskaya-2020/{n}") for n in ("r1", "r2"))
    assert {k for k in r1.values if r1.values[k] != r2.values[k]} == {"drum.inertia"}
    assert r1.system == r2.system
    assert r2.title == "R2, u = 20"


@pytest.mark.parametrize("name", ["table-5.1", "table-a.1"])
def test_printed_sets_that_are_no_machine_carry_a_warning(name):
    warnings = load_machine(f"drozdetskaya-2020/{name}").warnings
    assert any("no machine has these parameters" in w for w in warnings)


@pytest.mark.parametrize("name", ["r1", "r2", "table-3.1-laval", "table-3.1-carrier"])
def test_the_others_carry_none(name):
    assert load_machine(f"drozdetskaya-2020/{name}").warnings == ()


def test_a_wrong_name_is_answered_with_the_nearest():
    name = "drozdetskaya-2020/tabel-5.1"
    with refused("FILE", "drozdetskaya-2020/table-5.1", given=name, code="unknown-name"):
        load_machine(name)


@pytest.mark.parametrize(
    ("name", "clause"),
    [
        ("practice/nothing", ""), ("nothing", ""), ("../../etc/passwd", ""), ("kaltofen-cam/nothing", ""), ("", ""),
        ("laundri", "did you mean 'practice/laundry-drum'? "), ("r1", "did you mean 'drozdetskaya-2020/r1', "),
        ("drozdetskaya-2020/r3", "did you mean 'drozdetskaya-2020/r1', 'drozdetskaya-2020/r2'? "),
        ("Practice/Screan", "did you mean 'practice/screen', "), ("sperling", "did you mean 'sperling-rollers/"),
    ],
)  # fmt: skip
def test_only_names_that_are_like_it_or_contain_it_are_suggested(name: str, clause: str) -> None:
    text = nearest_names(name, names())
    assert text.startswith(clause or "`") and text.endswith("`wucht list` prints all names")
    assert text.count("'") <= 6


@pytest.mark.parametrize(
    ("path", "value", "refusal"),
    [
        ("v", 1.0, refused("machine.set.v", given=1.0, code="unknown-parameter")),
        ("u", -1.0, refused("machine.parameters.u", code="limits")),
        ("u", "1 m", refused("machine.parameters.u", code="dimension")),
    ],
)
def test_wrong_settings_are_refused(path, value, refusal):
    with refusal:
        load_machine("drozdetskaya-2020/table-5.1", {path: value})


@pytest.mark.slow
def test_a_long_chain_of_files_that_use_each_other(here):
    """Far beyond what Python calls within a call: the values that are set nearest hold, and the nearest title,
    with what is set beyond it."""
    links = 1500
    for i in range(links):
        own = f"set = {{ u = {i}.0 }}" if i in (2, 3) else 'title = "The tenth"' if i == 10 else ""
        Path(f"{i}.toml").write_text(f'[machine]\nuse = "{i + 1}.toml"\n{own}\n', encoding="utf-8")
    Path(f"{links}.toml").write_text('[machine]\nuse = "drozdetskaya-2020/table-5.1"\n', encoding="utf-8")
    machine = load_machine("0.toml")
    assert machine.values["u"] == 2.0
    assert machine.title == "The tenth (changed: u = 2)"
    Path(f"{links}.toml").write_text('[machine]\nuse = "none-5.1"\n', encoding="utf-8")
    with pytest.raises(InputError, match=rf"^0\.toml: {links}\.toml: machine\.use: given 'none-5\.1'; must be") as unknown:
        load_machine("0.toml")
    assert unknown.value.code == "unknown-name"
    Path(f"{links}.toml").write_text('[machine]\nuse = "7.toml"\n', encoding="utf-8")
    with pytest.raises(InputError, match=rf"^0\.toml: {links}\.toml: machine\.use: .* in a circle$"):
        load_machine("0.toml")


SCHEDULED = """
[machine]
use = "practice/fan-on-belt"
[[machine.schedules]]
parameter = "load.coefficient"
points = [["0 s", 0.0], ["5 s", "4e-4 N m s^2"]]
"""
FASTER = """
[machine]
use = "scheduled.toml"
[[machine.schedules]]
parameter = "drive.frequency"
points = [["0 s", "0 Hz"], ["3 s", "50 Hz"]]
voltage = "proportional"
boost = "20 V"
"""


def test_schedules_are_added_to_those_of_the_machine_used(here):
    """Those of the same parameter are replaced, with what they say of the voltage; the title tells which it does not know."""
    Path("scheduled.toml").write_text(SCHEDULED)
    Path("faster.toml").write_text(FASTER)
    used, added, faster = (load_machine(n) for n in ("practice/fan-on-belt", "scheduled.toml", "faster.toml"))
    assert {s.parameter for s in added.schedules} == {"load.coefficient", *(s.parameter for s in used.schedules)}
    assert added.at(2.5).values["load.coefficient"] == pytest.approx(2e-4)
    assert added.at(3.0).values["drive.frequency"] == used.at(3.0).values["drive.frequency"]
    assert faster.at(1.5).values["drive.frequency"] == pytest.approx(faster.at(3.0).values["drive.frequency"] / 2)
    assert faster.at(0.0).values["drive.voltage"] == pytest.approx(20.0)
    assert faster.at(2.5).values["load.coefficient"] == pytest.approx(2e-4)
    assert faster.title == f"{used.title} (changed: drive.frequency = over time, load.coefficient = over time)"


@pytest.mark.parametrize(
    ("lines", "refusal"),
    [
        ("schedules = 3", refused("machine.schedules", given=3, file="own.toml")),
        ("schedules = [1]", refused("machine.schedules", given=[1], file="own.toml")),
        (
            'schedules = [{ parameter = "drive.slope", points = [[0, 1]] }]',
            refused("machine.schedules[0].parameter", given="drive.slope", code="unknown-parameter", file="own.toml"),
        ),
        (
            "schedules = [{ points = [[0, 1]] }]",
            refused("machine.schedules[0].parameter", given=None, code="unknown-parameter", file="own.toml"),
        ),
        (
            'schedules = [{ parameter = "load.coefficient", points = [[0, -1]] }]',
            refused("machine.schedules[0].points (t = 0)", given=-1.0, code="limits", file="own.toml"),
        ),
        (
            'schedules = [{ parameter = "drive.voltage", points = [[0, 1]] }]',
            refused("machine.schedules[1].parameter", given="drive.voltage", file="own.toml"),
        ),
        (
            "schedules = [" + '{ parameter = "load.coefficient", points = [[0, 1]] },' * 2 + "]",
            refused("machine.schedules[1].parameter", given="load.coefficient", file="own.toml"),
        ),
        ("bodies = []", refused("machine.bodies", given=None, file="own.toml")),
    ],
)
def test_schedules_that_do_not_fit_the_machine_used(here, lines, refusal):
    Path("own.toml").write_text(f'[machine]\nuse = "practice/fan-on-belt"\n{lines}\n')
    with refusal:
        load_machine("own.toml")


def test_equations_of_another_file_take_no_schedules(here):
    Path("own.toml").write_text('[system]\nuse = "drozdetskaya-2020/figure-2.13"\nschedules = []\n')
    with refused("system.schedules", given=None):
        load_equations("own.toml")


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('use = "practice/screen"', "use: given 'practice/screen'; this key belongs in the table [machine]"),
        ("until = 3", "until: given 3; this key belongs in the table [study]"),
        ("[[bodies]]", "bodies: given [{}]; this key belongs in the table [machine]"),
    ],
)
def test_a_key_above_its_table(tmp_path: Path, line: str, says: str) -> None:
    (tmp_path / "a.toml").write_text(line + "\n")
    with pytest.raises(InputError) as refusal:
        read_study(str(tmp_path / "a.toml"))
    assert says in str(refusal.value)


@pytest.mark.parametrize(
    ("setting", "refusal"),
    [
        (
            '"p3.mass" = 1',
            refused("machine.set.p3.mass", "outer.toml", "p2", given=1, file="inner.toml", code="unknown-parameter"),
        ),
        (
            '"p1.mass" = -1',
            refused("machine.bodies[1] (p1).mass", "outer.toml", "0 kg", given=-1, code="limits", file="inner.toml"),
        ),
    ],
)
@pytest.mark.parametrize("titled", [True, False])
def test_a_wrong_setting_is_told_at_the_file_that_has_it(here, setting, refusal, titled):
    """It may be set right in a file that uses that one; then nothing is said."""
    machine = (FOLDER / "drozdetskaya-2020/r1.toml").read_text(encoding="utf-8")
    lines = [line for line in machine.splitlines() if titled or not line.startswith("title")]
    Path("used.toml").write_text("\n".join(lines), encoding="utf-8")
    Path("inner.toml").write_text(f'[machine]\nuse = "used.toml"\nset = {{ {setting} }}\n')
    Path("middle.toml").write_text('[machine]\nuse = "inner.toml"\nset = { "p2.mass" = 0.126 }\n')
    Path("outer.toml").write_text('[machine]\nuse = "middle.toml"\n')
    with refusal as caught:
        load_machine("outer.toml")
    assert caught.value.file == "inner.toml"
    if "p1" in setting:
        with refused("machine.set.p4.mass", given=1, file="outer.toml", code="unknown-parameter"):
            load_machine("outer.toml", {"p1.mass": 0.1, "p4.mass": 1})
        assert load_machine("outer.toml", {"p1.mass": 0.1}).values["p1.mass"] == 0.1


def test_a_missing_key_that_was_written_for_another_study_keeps_its_code(here):
    """The keys of a sweep are not taken for those of a probability; the sentence says so, and the error is the same."""
    question = '[machine]\nuse = "drozdetskaya-2020/r1"\n[study]\nkind = "sweep"\nalong = "drive.slope"\nrange = [0.01, 0.02]\n'
    Path("swept.toml").write_text(question, encoding="utf-8")
    with refused("study.along", "ignored", code="missing", file="swept.toml"):
        read_study("swept.toml", {"study.kind": "capture-probability"})
