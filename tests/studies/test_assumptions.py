"""Every answer says what it assumed, in its Dataset, its report, its JSON and its figure."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from wucht import (
    JOURNAL,
    Approximation,
    Basin,
    LoadSpectrum,
    OptimiseBalancer,
    Records,
    Response,
    RunUp,
    SpeedCurve,
    SynchronousStates,
    draw,
    load_equations,
    load_machine,
    report,
    run,
)
from wucht.files.catalogue import load_document, machine_of
from wucht.plots.arranging import arrange
from wucht.plots.page import page_context
from wucht.plots.sheet import new_figure, write_assumptions
from wucht.studies.assumptions import assumptions
from wucht.studies.registry import studies
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS, Study

R1, DIMENSIONLESS = "drozdetskaya-2020/r1", "drozdetskaya-2020/table-5.1"
WITHOUT, KEPT = (f"averaged equations {word} the inertia of the balancing bodies" for word in ("without", "with"))
MOTOR = "drum driven by its motor (linear)"
SECOND = KEPT.replace(AVERAGED_EQUATIONS, f"{AVERAGED_EQUATIONS} of second order")
CLOSED, DAMPING = "steady vibration of a linear carrier, in closed form", {"damping": (0.1, 1)}
AT_ZERO = "balancing bodies start at p1 0°, p2 0° relative to their rotor, at rest"
SCREEN, MOTORS = "practice/screen", ["e1 driven by its motor (induction); e2 driven by its motor (induction)"]
TURNING = "balancing bodies start at r1 0°, r2 0° relative to their rotor"
LOST = [{"parameter": "drives.e2.voltage", "points": [[0.0, 230.0], [5.0, 0.0]], "interpolation": "steps"}]
SAYS_BY_ITS_DATASET = {"comparison", "phase-portrait", "cam-prediction"}


@pytest.mark.parametrize(
    ("name", "spec", "statements"),
    [
        (R1, RunUp(until=1.0), [FULL_EQUATIONS, MOTOR, AT_ZERO]),
        (R1, RunUp(until=1.0, model="slow"), [WITHOUT, MOTOR, AT_ZERO]),
        (R1, RunUp(until=1.0, model="slow", inertia=True, order=2), [SECOND, MOTOR, AT_ZERO]),
        (R1, RunUp(until=1.0, model="both"), [f"{FULL_EQUATIONS} and {WITHOUT}", MOTOR, AT_ZERO]),
        (R1, Approximation(), [f"{FULL_EQUATIONS}, compared with {WITHOUT}", MOTOR, AT_ZERO]),
        (R1, Basin(axes={"p1": (0, 6, 3), "p2": (0, 6, 3)}, model="slow"), [WITHOUT, MOTOR]),
        (R1, OptimiseBalancer(vary=DAMPING, model="slow"), [f"{KEPT} for the search, {FULL_EQUATIONS} for the front", MOTOR]),
        (R1, SpeedCurve(along="drive.slope", range=(0.01, 0.1)), [KEPT, MOTOR]),
        (R1, SynchronousStates(), [f"{KEPT} for the states, {FULL_EQUATIONS} for their stability", MOTOR]),
        (R1, SynchronousStates(full=False, speed=150.0), [KEPT, "the main rotor held at study.speed"]),
        (R1, Response(), [CLOSED, "all bodies turn at each speed of the range"]),
        (DIMENSIONLESS, RunUp(until=1.0, model="slow"), [WITHOUT, "rotor driven with limited power", AT_ZERO]),
        (DIMENSIONLESS, SpeedCurve(along="u", range=(1, 2)), [WITHOUT, "rotor driven with limited power"]),
        ("sperling-rollers/table-2", RunUp(until=1.0), [FULL_EQUATIONS, "drum at its given speed", TURNING]),
        (R1, RunUp(until=1.0, start={"p1": 0.3}),
        [FULL_EQUATIONS, MOTOR, "balancing bodies start at p2 0° relative to their rotor, at rest"]),
        (R1, RunUp(until=1.0, start={"psi": 0.3}), [FULL_EQUATIONS, MOTOR]),
        (SCREEN, RunUp(until=1.0), [FULL_EQUATIONS, *MOTORS, "start: at rest, hanging"]),
        (SCREEN, RunUp(until=1.0, start={"e1": 1.0}), [FULL_EQUATIONS, *MOTORS, "rotors start at e2 0°, at rest"]),
        (R1, RunUp(until=1.0, starts=({"p1": 0.3, "p2": 1.0}, {"p2": 0.3})),
        [FULL_EQUATIONS, MOTOR, AT_ZERO.replace(", p2 0°", "")]),
        ("sperling-vibration/figure-2a", RunUp(until=1.0, model="slow"),
        [AVERAGED_EQUATIONS, "rotor driven by its motor (linear)"]),
    ],
)  # fmt: skip
def test_what_follows_from_question_and_machine(name: str, spec: Study, statements: list[str]) -> None:
    assert assumptions(spec, load_machine(name)) == statements


def test_own_equations() -> None:
    equations = load_equations("drozdetskaya-2020/figure-2.13")
    assert assumptions(SpeedCurve(along="mu", range=(0, 1)), equations) == ["the equations as the file gives them"]


@pytest.mark.parametrize("kind", [kind for kind, study in studies().items() if study.package.startswith("wucht.")])
def test_no_study_keeps_its_equations_to_itself(kind: str) -> None:
    spec = studies()[kind].study
    assert spec.solves or "model" in spec.model_fields or "equations" in vars(spec) or kind in SAYS_BY_ITS_DATASET


def test_it_is_said_everywhere(wucht: Callable[..., Any], study: Callable[..., Path]) -> None:
    words = ("run", study(), "-o", "out", "--set", "study.kind=response", "--set", "study.bodies=held")
    spoken = wucht(*words).out
    document = wucht(*words, "--json").document
    assert document["assumed"][-1] == "balancing bodies held at p1 17.19°, p2 -28.65° relative to their rotor"
    assert f"  assumed      {'; '.join(document['assumed'])}\n" in spoken
    assert json.loads(Path("out/summary.json").read_text("utf-8"))["assumed"] == document["assumed"]


def test_the_figure_says_it_below_its_heading() -> None:
    result = run(RunUp(until=0.05), load_machine(R1))
    assert result.wucht.assumed == [FULL_EQUATIONS, MOTOR, AT_ZERO]
    assert f"  assumed      {FULL_EQUATIONS}; {MOTOR}; {AT_ZERO}" in report(result)
    drawn = draw(result)
    (small,) = drawn.texts[1:] if drawn.texts[0] is drawn._suptitle else drawn.texts  # type: ignore[attr-defined]
    assert " ".join(small.get_text().split()) == f"assumed: {FULL_EQUATIONS}; {MOTOR}; {AT_ZERO}"
    earlier = result.copy()
    del earlier.attrs["assumed"]  # one that an earlier version wrote
    assert all("assumed" not in text.get_text() for text in draw(earlier).texts)


@pytest.mark.parametrize("statements", [["short"], ["long " * 30, "and more " * 30]])
def test_panels_keep_their_height_and_their_distance_from_the_statements(statements: list[str]) -> None:
    def made(stated: list[str]) -> tuple[Figure, float]:
        figure, axes = new_figure(2, "Title", "sentence")
        write_assumptions(figure, stated)
        return arrange(figure), round(axes[0].get_position().height * figure.get_figheight(), 6)

    (figure, height), (_, before) = made(statements), made([])
    assert height == before
    figure.canvas.draw()
    stated, renderer = figure.texts[-1], figure.canvas.get_renderer()  # type: ignore[attr-defined]
    box = stated.get_window_extent(renderer)
    assert box.y0 > figure.axes[0].get_window_extent(renderer).y1
    assert box.y1 <= figure._suptitle.get_window_extent(renderer).y0 + 2  # type: ignore[attr-defined]
    assert (box.x0 > 0, box.x1 < figure.bbox.x1) == (True, True)


def test_a_column_of_a_journal_has_no_heading_and_no_statements() -> None:
    with page_context(JOURNAL):
        figure, _ = new_figure(1, "Title", "sentence")
        write_assumptions(figure, ["short"])
    assert arrange(figure).texts == []


@pytest.mark.parametrize(
    ("schedules", "second"),
    [
        (LOST, " until 5 s, then without its torque"),
        ([LOST[0] | {"points": [[0.0, 230.0], [5.0, 0.0], [6.0, 230.0]]}], ""),
        ([LOST[0] | {"points": [[0.0, 230.0], [5.0, 0.0]], "interpolation": "linear"}], " until 5 s, then without its torque"),
        ([LOST[0] | {"points": [[0.0, 230.0], [5.0, 20.0]]}], ""),
    ],
)
def test_a_motor_whose_voltage_a_schedule_takes_away(schedules: list[dict[str, Any]], second: str) -> None:
    document, path = load_document("practice/screen")
    machine = machine_of({"machine": document["machine"] | {"schedules": schedules}}, path, "screen", {})[0]
    turning = next(x for x in assumptions(RunUp(until=9.0), machine) if "driven" in x)
    assert turning == f"e1 driven by its motor (induction); e2 driven by its motor (induction){second}"


def test_a_record_has_no_equations(tmp_path: Path) -> None:
    assert assumptions(LoadSpectrum(signal={"file": "a.csv", "column": "force"}), Records(tmp_path, "a record")) == []
