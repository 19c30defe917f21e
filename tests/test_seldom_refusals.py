"""What is seldom refused or chosen: folders, fingerprints, versions, signals, start states, ranges."""

from __future__ import annotations

import gc
import os
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

import wucht
from wucht import cli
from wucht.analysis.averaged import averaged_machine
from wucht.cams.prediction import _newton
from wucht.cams.tables.camshaft import ElasticTable, ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicTable
from wucht.dynamics.entrainment.branches import Edge, StableRange
from wucht.dynamics.entrainment.entrainment_case import AMPLITUDE
from wucht.dynamics.entrainment.existence import Existence, range_around, threshold
from wucht.dynamics.run_ups.machine_signals import machine_signal
from wucht.dynamics.run_ups.varied import start_states, varied_of
from wucht.dynamics.work import Work
from wucht.errors import RunError, WuchtError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.numerics.recurrence import recurrence
from wucht.results import provenance
from wucht.results.provenance import check_attributes
from wucht.results.store import prepare_folder
from wucht.studies import memory
from wucht.studies.cam_prediction import computation as prediction_run
from wucht.studies.registry import Study
from wucht.studies.subjects import MACHINE, OfMachineOrSystem, _text

ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
HELD = {"kind": "constant-speed", "speed": 100.0}
MOTOR = {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}


# --- averaged equations, signals, start states ---


@pytest.mark.parametrize(
    ("motion", "drive", "code"),
    [
        ({"direction": "x", "points": [[0, 0], [1, 1e-3], [2, 0], [3, 1e-3], [4, 0]]}, MOTOR, "table"),
        ({"direction": "x", "amplitude": 1e-3, "frequency": 6.0}, HELD, "no-common-speed"),
    ],
)
def test_shaken_machines_without_averaged_equations(motion: dict[str, Any], drive: dict[str, Any], code: str) -> None:
    machine = machine_from({"carrier": {"directions": "x", "motion": motion}, "bodies": [ROTOR], "drive": drive})
    with refused("machine", code=code):
        averaged_machine(machine)


def test_signals_that_a_machine_has_not() -> None:
    fixed = machine_from({"carrier": {"directions": "fixed"}, "bodies": [ROTOR], "drive": MOTOR})
    with refused("study.signal", "does not move", given="displacement"):
        machine_signal(fixed, "displacement", None)
    moving = machine_from({"carrier": {"directions": "x", "stiffness": 1e4, "damping": 1.0}, "bodies": [ROTOR], "drive": MOTOR})
    with refused("study.failure.direction", "x", given="y"):
        machine_signal(moving, "displacement", "y", "study.failure")
    assert machine_signal(moving, "spring-force", None).name == "force of the springs in x"
    assert (machine_signal(moving, "acceleration", None).unit, machine_signal(moving, "displacement", "x").unit) == (
        "m/s^2",
        "m",
    )


def test_start_states_of_a_slider() -> None:
    machine = load_machine("sperling-vibration/figure-7")
    slider, _ = machine.sliders
    states = start_states(machine)
    out, moving = states[f"{slider.name}.displacement"], states[f"{slider.name}.velocity"]
    assert states[slider.name] is out
    assert (out.unit.si, moving.unit.si) == ("m", "m/s") and out.what == f"displacement of {slider.name} at the start"
    assert moving.what == f"velocity of {slider.name} at the start"


def test_the_motion_of_a_held_body_is_not_varied() -> None:
    machine = machine_from({"carrier": {"stiffness": 1e4, "damping": 1.0}, "bodies": [ROTOR], "drive": HELD})
    for name in ("drum", "drum.angle", "drum.speed"):
        with refused("study.along", given=name, code="prescribed"):
            varied_of(machine, name, "along")
    with refused("study.along", given="drum.sped", code="unknown-name"):
        varied_of(machine, "drum.sped", "along")


# --- ranges of entrainment ---


def case(name: str, own: float, *limits: float) -> Any:
    return SimpleNamespace(swept=SimpleNamespace(name=name, own=own), limits=limits, machine=SimpleNamespace(shaken=object()))


def band(low: float, high: float, kind: str = "fold") -> StableRange:
    return StableRange(0, Edge(low, kind), Edge(high, "range"), np.array([0]))


def test_the_range_about_a_band() -> None:
    first, largest, margin = 0.5, 3.0, 0.2
    assert range_around(case(AMPLITUDE, 3.0, 0.0, 50.0), band(2.0, 9.0)) == (first * 2.0, largest * 3.0)
    assert range_around(case(AMPLITUDE, 1.0, 0.0, 50.0), band(2.0, 9.0)) == (first * 2.0, largest * 2.0)
    assert range_around(case(AMPLITUDE, 1.0, 0.0, 50.0), band(2.0, 9.0, "range")) == (first * 2.0, largest * 1.0)
    assert range_around(case("slope", 3.0, -90.0, 90.0), band(2.0, 5.0)) == (2.0 - 3 * margin, 5.0 + 3 * margin)
    assert range_around(case("slope", 7.0, -90.0, 90.0), band(2.0, 5.0)) == (2.0 - 5 * margin, 7.0 + 5 * margin)
    assert range_around(case("slope", 7.0, 1.9, 7.1), band(2.0, 5.0)) == (1.9, 7.1)
    assert range_around(case("slope", -7.0, -90.0, 90.0), None) == (-14.0, 0.0)
    assert range_around(case("slope", 0.0, -90.0, 110.0), None) == (-2.0, 2.0)


def test_the_threshold_along_the_amplitude_is_where_its_band_begins() -> None:
    def of(found: StableRange | None) -> float | None:
        return threshold(case(AMPLITUDE, 1.0, 0.0, 9.0), Existence(equations=object(), band=found), Work())  # type: ignore[arg-type]

    assert (of(band(2.0, 9.0)), of(band(2.0, 9.0, "range")), of(None)) == (2.0, None, None)
    assert threshold(case(AMPLITUDE, 1.0, 0.0, 9.0), Existence(band=band(2.0, 9.0)), Work()) is None


# --- cam drives ---


LAW = HarmonicTable(harmonics=2, coefficients={"mean": 0.1, "cosine": [-0.1]})


def test_the_motion_for_which_a_cam_is_corrected() -> None:
    held = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=6.0, drive=HELD | {"speed": 50.0}))
    motion = held.turning_with_corrected_cam
    assert motion.mean == pytest.approx(50.0) and motion.fluctuation == pytest.approx(0.0, abs=1e-12)
    free = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=6.0, mean_speed=50.0)).turning_with_corrected_cam
    assert free.mean == pytest.approx(50.0) and free.fluctuation > 1e-4
    with refused("speed", given=None, code="missing"):
        _ = wucht.CamDrive(LAW).turning_with_corrected_cam


# --- files, folders, versions ---


def test_folders_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with refused("-o", "nothing can be written there", given=str(tmp_path / "file" / "in")):
        prepare_folder(tmp_path / "file" / "in")
    with refused("-o", "this cannot be the name of a folder", given="a\0b"):
        prepare_folder(Path("a\0b"))
    (tmp_path / "out" / "result.nc").mkdir(parents=True)
    with refused("-o", "result.nc", given=str(tmp_path / "out"), code="folder"):
        prepare_folder(tmp_path / "out", ["result.nc"])


def test_what_is_kept_in_a_folder_that_another_process_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(*_: Any) -> Any:
        raise FileNotFoundError

    def full(*_: Any) -> Any:
        raise PermissionError(13, "Permission denied")

    (tmp_path / "a").mkdir()
    with monkeypatch.context() as patch:
        patch.setattr(Path, "glob", gone)
        assert memory._found(tmp_path, "*") == []
    memory._remove(tmp_path / "nothing", tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "rename", full)
        with refused("-o", "nothing can be written there: Permission denied", given=str(tmp_path)):
            memory._remove(tmp_path / "a", tmp_path)
    memory._remove(tmp_path / "a", tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_package_that_is_not_installed_is_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    def version(name: str) -> str:
        if name == "heyoka":
            raise provenance.PackageNotFoundError
        return f"{name} 1"

    monkeypatch.setattr(provenance, "version", version)
    found = provenance.versions.__wrapped__()
    assert (found["heyoka"], found["numpy"]) == ("not installed", "numpy 1")


def test_fingerprints_are_of_what_is_known() -> None:
    assert _text(frozenset({3, 1})) == _text(frozenset({1, 3})) != _text(frozenset({1}))
    with pytest.raises(TypeError, match="no fingerprint is known of a object"):
        _text({"a": object()})


# --- studies, subjects ---


def test_studies_that_lack_something(monkeypatch: pytest.MonkeyPatch) -> None:
    import types

    whole = types.ModuleType("own_study_without_functions")
    monkeypatch.setitem(sys.modules, whole.__name__, whole)
    study = Study("own", whole.__name__)
    with pytest.raises(WuchtError) as raised:
        _ = study.run
    assert str(raised.value) == "the study 'own' (own_study_without_functions) has no function 'run'"
    assert study.line == "the study 'own' (own_study_without_functions) has no spec of that kind"
    assert study.tiled is False
    whole.prepare = whole.run = whole.dataset = whole.figure = lambda *_: None  # type: ignore[attr-defined]
    whole.report = "words"  # type: ignore[attr-defined]
    with pytest.raises(WuchtError, match=r"\(own_study_without_functions\): report must be a function$"):
        study.check()


def test_subjects_are_machines_or_equations(tmp_path: Path) -> None:
    with refused("machine", "asked of a machine", given="drum"):
        MACHINE.describe("drum")
    either = OfMachineOrSystem()
    with refused("machine", given=None):
        either.read({"study": {}}, tmp_path, "a", {})
    with refused("system", given=None):
        either.read({"study": {}, "system": {}, "machine": {}}, tmp_path, "a", {})


# --- the process of the command line ---


def test_a_shell_is_answered_with_words(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["wucht", "complete-words", "wucht", "ru"])
    monkeypatch.setattr(gc, "freeze", lambda: None)
    monkeypatch.setattr("wucht.cli.completing.words", lambda line: ["run", line])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 0 and capsys.readouterr().out == "run\nwucht ru\n"


def test_a_reader_that_is_gone_is_no_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    class Gone:
        def __init__(self, file: Any) -> None:
            self.file = file

        def flush(self) -> None:
            raise BrokenPipeError

        def fileno(self) -> int:
            return int(self.file.fileno())

    with (tmp_path / "out").open("wb", buffering=0) as file:
        monkeypatch.setattr(sys, "stdout", Gone(file))
        monkeypatch.setattr(sys, "stderr", None)
        monkeypatch.setattr(gc, "freeze", lambda: None)
        with pytest.raises(SystemExit) as ended:
            cli._leave(3)
        os.write(file.fileno(), b"what is left")
    assert ended.value.code == 3 and (tmp_path / "out").read_bytes() == b"", "it goes nowhere"


# --- recurrence ---


def test_what_does_not_move_or_return_does_not_repeat_itself() -> None:
    time = np.linspace(0.0, 10.0, 401)
    none = np.zeros(1, bool)
    assert recurrence(time, np.ones((1, 401)), none) is None
    assert recurrence(time, time[None], none) is None
    once = recurrence(time, np.sin(2 * np.pi * time / 8.0)[None], none)
    assert once is None, "it has returned but once"
    found = recurrence(time, np.stack([np.sin(2 * np.pi * time / 2.5), np.cos(2 * np.pi * time / 2.5)]), np.zeros(2, bool))
    assert found is not None and found.period == pytest.approx(2.5, rel=1e-3) and found.turns.tolist() == [0, 0]


# --- springs, motions and results that are wrong ---


def test_the_damping_of_an_output_on_a_spring() -> None:
    """Given itself, or by its ratio to the critical one, 2 sqrt(c m)."""
    common = {"output_stiffness": 400.0}
    assert ElasticTable(**common, output_damping=3.0).output(4.0, "rad").damping == 3.0
    assert ElasticTable(**common, output_damping_ratio=0.25).output(4.0, "rad").damping == pytest.approx(0.25 * 2 * 40.0)
    with refused("shaft.elastic.output_damping", "negative", given=-3.0):
        ElasticTable(**common, output_damping=-3.0).output(4.0, "rad")
    with refused("shaft.elastic.output_stiffness", "above zero", given=0.0):
        ElasticTable(output_stiffness=0.0).output(4.0, "rad")


def test_a_balance_of_positive_unknowns() -> None:
    def square(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x**2 - 9.0, np.diag(2 * x)

    assert _newton(square, np.array([50.0]), lambda: "more") == pytest.approx([3.0], rel=1e-12)
    for balance in (
        lambda x: (x * 0 + 1.0, np.zeros((1, 1))),  # the same at all speeds
        lambda x: (x**2 + 1.0, np.diag(2 * x)),  # nowhere closed
    ):
        with pytest.raises(RunError) as raised:
            _newton(balance, np.array([1.0]), lambda: "take a larger flywheel")
        assert raised.value.code == "no-convergence" and ": take a larger flywheel; and a drive" in str(raised.value)


def test_a_cut_cam_without_a_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was cut before it is kept."""

    def left_by(cam: Any, count: int) -> Any:
        made.append(cam)
        if len(made) == 3:
            raise RunError("it stands")
        return 0.5 / len(made), SimpleNamespace()

    made = list[Any]()
    monkeypatch.setattr(prediction_run, "CorrectedLaw", lambda law, shaft: (law, shaft))
    plan = SimpleNamespace(cuts=5, count=4, motion=SimpleNamespace(law="law"), shaft=SimpleNamespace(left_by=left_by))
    left, failure = prediction_run._cuts(plan, Work())  # type: ignore[arg-type]
    assert left.tolist() == [0.5, 0.25] and len(made) == 3 and made[0] == "law" and made[1][0] == "law"
    assert failure == "with cam 3, cut for the speed measured with the one before: it stands"


def test_attributes_of_a_result_that_was_edited() -> None:
    whole = {
        "study": "a", "title": "b", "sentence": "c", "failure": "", "finished": 1, "dimensionless": 0, "summary": "{}",
        "input": '{"study": {}, "machine": {}}', "warnings": "[]",
    }  # fmt: skip
    check_attributes(whole)
    with refused("input", "of which machine", given=None):
        check_attributes(whole | {"input": '{"study": {}}'})
    with refused("warnings", "list of texts"):
        check_attributes(whole | {"warnings": "[3]"})
    with refused("notes", "list of texts"):
        check_attributes(whole | {"notes": "[[]]"})
    with refused("title", "another type", given=3):
        check_attributes(whole | {"title": 3})
    with refused("title", "is missing", given=None):
        check_attributes({k: v for k, v in whole.items() if k != "title"})
