"""The study ``activation``: against run-ups of machines written by hand, resumed, refused, reported and drawn."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.refusals import refused

from interrupting import assert_same, stop_at, stopped_often
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.numerics.observers.turns import LargestTurn
from wucht.studies.activation import computation
from wucht.studies.activation.computation import prepare
from wucht.studies.activation.figure import _peaks
from wucht.studies.activation.spec import Activation
from wucht.studies.run_up.study import RunUp
from wucht.studies.runner import draw, load, report
from wucht.studies.runner import run as ask

MACHINE = load_machine("drozdetskaya-2020/switchable-pendulums")
SHORT = {"until": "1.5 s", "orientations": [0.5], "phases": 1}
CARRIER = {"stiffness": 1e5, "damping": 200.0}
DRIVE = {"kind": "linear", "on": "drum", "slope": 0.078, "no_load_speed": 200.0}


def drum(mass: float) -> dict[str, Any]:
    return {"kind": "rotor", "name": "drum", "mass": mass, "unbalance": 9.75e-3, "inertia": 0.0338}


@pytest.mark.slow
def test_each_variant_is_the_run_up_of_its_machine() -> None:
    """Rigid: 0.75 kg with 0.013 kg m and 0.01 + 0.25 0.104^2 kg m^2 each, by hand; none: 10 kg. Peaks to the last digits."""
    given = SHORT | {"phases": 2, "activation_speeds": [120.0, 150.0]}
    s = ask(Activation(**given), MACHINE).wucht.summary
    rigid = [
        {
            "kind": "pendulum",
            "name": n,
            "about": "drum",
            "mass": 0.75,
            "length": 0.013 / 0.75,
            "inertia": 0.012704,
            "damping": 0.05,
        }
        for n in ("p1", "p2")
    ]
    starts = [{"p1": phase - 0.25, "p2": phase + 0.25} for phase in (0.0, math.pi)]
    hand = machine_from({"carrier": CARRIER, "bodies": [drum(8.5), *rigid], "drive": DRIVE})
    bare = machine_from({"carrier": CARRIER, "bodies": [drum(10.0)], "drive": DRIVE})
    early = MACHINE.with_values({f"{n}.preload": 0.25 * 0.052 * 120.0**2 for n in ("p1", "p2")})

    def peaks(machine: Any) -> list[float]:
        return [ask(RunUp(until="1.5 s", start=start), machine).wucht.summary["peak_amplitude"] for start in starts]

    assert s["none"]["peak_amplitude"] == pytest.approx(
        ask(RunUp(until="1.5 s"), bare).wucht.summary["peak_amplitude"], rel=1e-9
    )
    for group, machine in ((s["rigid"][0], hand), (s["switchable"][0], early), (s["switchable"][1], MACHINE)):
        assert group["peak_amplitude"] == pytest.approx(max(peaks(machine)), rel=1e-6)
    assert [g["activation_speed"] for g in s["switchable"]] == pytest.approx([120.0, 150.0])
    assert s["switchable"][0]["opened_at"] == pytest.approx(120.0, rel=0.03)
    assert s["energy_residual"] < 1e-10


@pytest.mark.slow
def test_an_interrupted_study_is_resumed(tmp_path: Path) -> None:
    question = Activation(until="0.2 s", orientations=[0.5, 1.0], phases=2)
    assert_same(ask(question, MACHINE), stopped_often(question, MACHINE, tmp_path, 2, 3))


def test_what_is_missing_is_told(tmp_path: Path) -> None:
    question = Activation(until="0.2 s", orientations=[0.5, 1.0], phases=2)
    part = ask(question, MACHINE, folder=tmp_path, progress=stop_at(6))
    assert not part.attrs["finished"]
    assert any("runs are missing" in w for w in part.wucht.warnings)
    assert np.isnan(part.peak.values).any()
    draw(part)
    report(part)


@pytest.mark.parametrize(
    ("changed", "key", "says"),
    [
        ({"activation_speeds": [-3.0]}, "study.activation_speeds", "greater than 0"),
        ({"orientations": [1.0, 1.0]}, "study.orientations", "twice"),
        ({"orientations": []}, "study.orientations", "at least one"),
        ({"orientations": "90 deg"}, "study.orientations", "must be a list"),
        ({"phases": 0}, "study.phases", "from 1"),
        ({"phases": 360, "activation_speeds": [float(w) for w in range(100, 120)]}, "study.phases", "at most 5000 runs"),
        ({"variants": ["stiff"]}, "study.variants[0]", "rigid"),
        ({"until": None}, "study.until", "missing"),
    ],
)
def test_questions_that_make_no_sense_are_refused(changed: dict[str, Any], key: str, says: str) -> None:
    with pytest.raises(InputError) as error:
        ask(Activation(**{k: v for k, v in (SHORT | changed).items() if v is not None}), MACHINE)
    assert key.removeprefix("study.").partition("[")[0] in error.value.location
    assert says in str(error.value)


def test_a_start_of_the_pendulums_and_a_machine_without_any_are_refused() -> None:
    for key in ("p1", "delta"):
        with refused(f"study.start.{key}", "study.orientations", "study.phases", given=0.3):
            ask(Activation(**SHORT, start={key: 0.3}), MACHINE)
    with refused("machine.bodies", given=["rotor", "pendulum", "pendulum"]):
        ask(Activation(**SHORT), load_machine("drozdetskaya-2020/r1"))


def test_pendulums_that_never_open_and_those_that_open_again_and_again_are_told() -> None:
    """180 rad/s is not reached in the time; at 105 rad/s they slow down to 88.2 and close below 92.3."""
    result = ask(
        Activation(**SHORT | {"until": "0.4 s", "variants": ["switchable"], "activation_speeds": [105.0, 180.0]}), MACHINE
    )
    s, warnings = result.wucht.summary, result.wucht.warnings
    assert s["switchable"][1]["peak_after"] is None
    assert s["switchable"][1]["orientations_at_activation"] == [None]
    assert s["pendulums"][0]["stays_open"] == [False, True]
    assert s["pendulums"][0]["after_opening"][0] == pytest.approx(105 * (0.01 + 0.25 * 0.052**2) / (0.01 + 0.25 * 0.104**2))
    assert sum("repeatedly" in w for w in warnings) == 2
    assert any("not all pendulums are open at the end" in w for w in warnings)


@pytest.mark.slow
def test_figure_and_report_tell_what_was_run(tmp_path: Path) -> None:
    question = Activation(
        until="1.5 s", orientations=["45 deg", "180 deg"], phases=2, variants=["switchable", "balanced", "rigid", "none"]
    )
    result = ask(question, MACHINE, folder=tmp_path)
    drawn = draw(load(tmp_path / "result.nc"))
    left, right = drawn.axes
    assert left.get_xlabel() == "speed of the rotor (rad/s)"
    assert left.get_ylabel() == "amplitude of the axis (mm)"
    assert right.get_xlabel() == "orientation at the start (°)"
    names = [t.get_text() for axis in drawn.axes for t in axis.get_legend().get_texts()]
    assert {"without pendulums", "switchable, 180°", "balanced, 45°", "rigid, 45°", "switchable", "rigid"} <= set(names)
    curve = next(line for line in left.get_lines() if line.get_label() == "rigid, 45°")
    assert 1e-3 * max(curve.get_ydata()) == pytest.approx(result.wucht.summary["rigid"][0]["peak_amplitude"], rel=0.05)
    lines = report(result)
    assert any(line.startswith("  p1, p2") and "opens at 150 rad/s" in line for line in lines)
    assert sum(line.startswith("  switchable") for line in lines) == 2
    speeds = ask(
        Activation(**SHORT | {"until": "0.2 s", "activation_speeds": [120.0, 150.0], "variants": ["switchable"]}), MACHINE
    )
    assert draw(speeds).axes[1].get_xlabel() == "activation speed (rad/s)"


def test_pendulums_start_at_their_orientations() -> None:
    """From each to the next the orientation, counter-clockwise, their mean at the phases, which divide a turn evenly."""
    plan = prepare(Activation(until="1.5 s", orientations=[0.5, 2.0], phases=4, variants=["switchable"]), MACHINE)
    assert plan.phases == pytest.approx((0.0, math.pi / 2, math.pi, 3 * math.pi / 2))
    starts = {(run.orientation, run.phase): [run.start[name] for name in plan.pendulums] for run in plan.runs}
    assert len(starts) == 8
    first, second = starts[1, 1]
    assert (first, second) == pytest.approx((math.pi / 2 - 1.0, math.pi / 2 + 1.0))
    assert starts[0, 3] == pytest.approx([1.5 * math.pi - 0.25, 1.5 * math.pi + 0.25])


def test_a_pendulum_is_open_at_the_end_if_its_mass_is_beyond_half_of_its_stroke_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two, one opens and closes again, the other opens late."""
    stroke = MACHINE.values["p1.outer_stop"] - MACHINE.values["p1.inner_stop"]
    shares = {"p1": [0.0, 0.9, 0.2], "p2": [0.0, 0.1, 0.9]}
    rows = {s.coordinate.position.name: stroke * np.array(shares[s.name]) for s in MACHINE.sliders}
    names = [b.name for b in MACHINE.bodies]
    made = {
        "body": names,
        "speed": np.ones((len(names), 3)),
        "angle": np.zeros((len(names), 3)),
        "amplitude": np.ones(3),
        "energy_residual": np.zeros(3),
    }
    motion = SimpleNamespace(
        rows=rows,
        machine_motion=SimpleNamespace(time=np.arange(3.0)),
        last=SimpleNamespace(trajectory=SimpleNamespace(end_time=2.0)),
        observation=SimpleNamespace(largest=1.0, rotors={"drum": SimpleNamespace(largest_turn=LargestTurn(1.0, 1.0))}),
        verdict=SimpleNamespace(outcome="compensated", speed=1.0),
        trajectory=SimpleNamespace(failure=None),
    )
    monkeypatch.setattr(computation, "run_up", lambda *_: iter([(motion,)]))
    monkeypatch.setattr(
        computation, "motion_quantities", lambda *_: [SimpleNamespace(name=k, value=v) for k, v in made.items()]
    )
    case = SimpleNamespace(machine=MACHINE, horizon=SimpleNamespace(expected_end=2.0))
    planned: Any = SimpleNamespace(of=computation.SWITCHABLE, case=lambda: case)
    assert computation._compute_run(planned, ("p1", "p2"), lambda *_: None).open_at_end == (False, True)


def test_peaks_are_drawn_where_some_are_missing() -> None:
    """Of two orientations the second has not been run."""
    some = np.array([[[2e-3, 4e-3], [math.nan, math.nan]]])
    named = {"units": "m", "long_name": "largest amplitude of the axis"}
    at = ("activation_speed", "orientation", "phase")
    result = xr.Dataset(
        {
            "peak": (at, some, named),
            "balanced_peak": (at[1:], some[0] + 1e-3, named),
            "rigid_peak": (at[1:], np.full((2, 2), math.nan), named),
            "none_peak": ((), math.nan, named),
        },
        {"activation_speed": [150.0], "orientation": [math.pi / 2, math.pi]},
    )
    axis = Figure().add_subplot()
    _peaks(axis, result)
    lines = {line.get_label(): np.column_stack(line.get_data()).tolist() for line in axis.get_lines()}
    assert lines == {"switchable": [[90.0, pytest.approx(3.0)]], "balanced": [[90.0, pytest.approx(4.0)]]}
