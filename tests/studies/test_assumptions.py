"""Every answer says what it assumed, in its Dataset, its report, its JSON and its figure."""

from __future__ import annotations

from pathlib import Path

import pytest

from wucht import (
    Approximation,
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
from wucht.studies.assumptions import assumptions
from wucht.studies.registry import studies
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS, Study

R1, DIMENSIONLESS = "drozdetskaya-2020/r1", "drozdetskaya-2020/table-5.1"
WITHOUT, KEPT = (f"averaged equations {word} the inertia of the balancing bodies" for word in ("without", "with"))
MOTOR = "drum driven by its motor (linear)"
SECOND = KEPT.replace(AVERAGED_EQUATIONS, f"{AVERAGED_EQUATIONS} of second order")
DAMPING = {"damping": (0.1, 1)}
AT_ZERO = "balancing bodies start at p1 0°, p2 0° relative to their rotor, at rest"
SCREEN, MOTORS = "practice/screen", ["e1 driven by its motor (induction); e2 driven by its motor (induction)"]
TURNING = "balancing bodies start at r1 0°, r2 0° relative to their rotor"
SAYS_BY_ITS_DATASET = {"comparison", "phase-portrait", "cam-prediction"}


@pytest.mark.parametrize(
    ("name", "spec", "statements"),
    [
        (R1, RunUp(until=1.0, model="slow", inertia=True, order=2), [SECOND, MOTOR, AT_ZERO]),
        (R1, RunUp(until=1.0, model="both"), [f"{FULL_EQUATIONS} and {WITHOUT}", MOTOR, AT_ZERO]),
        (R1, RunUp(until=1.0, start={"psi": 0.3}), [FULL_EQUATIONS, MOTOR]),
        (R1, RunUp(until=1.0, starts=({"p1": 0.3, "p2": 1.0}, {"p2": 0.3})),
        [FULL_EQUATIONS, MOTOR, AT_ZERO.replace(", p2 0°", "")]),
        (R1, Approximation(), [f"{FULL_EQUATIONS}, compared with {WITHOUT}", MOTOR, AT_ZERO]),
        (R1, OptimiseBalancer(vary=DAMPING, model="slow"), [f"{KEPT} for the search, {FULL_EQUATIONS} for the front", MOTOR]),
        (R1, SynchronousStates(), [f"{KEPT} for the states, {FULL_EQUATIONS} for their stability", MOTOR]),
        (R1, SynchronousStates(full=False, speed=150.0), [KEPT, "the main rotor held at study.speed"]),
        (DIMENSIONLESS, SpeedCurve(along="u", range=(1, 2)), [WITHOUT, "rotor driven with limited power"]),
        ("sperling-rollers/table-2", RunUp(until=1.0), [FULL_EQUATIONS, "drum at its given speed", TURNING]),
        (SCREEN, RunUp(until=1.0), [FULL_EQUATIONS, *MOTORS, "start: at rest, hanging"]),
        (SCREEN, RunUp(until=1.0, start={"e1": 1.0}), [FULL_EQUATIONS, *MOTORS, "rotors start at e2 0°, at rest"]),
    ],
)  # fmt: skip
def test_what_follows_from_question_and_machine(name: str, spec: Study, statements: list[str]) -> None:
    assert assumptions(spec, load_machine(name)) == statements


def test_own_equations() -> None:
    equations = load_equations("drozdetskaya-2020/figure-2.13")
    assert assumptions(SpeedCurve(along="mu", range=(0, 1)), equations) == ["the equations as the file gives them"]


def test_no_study_keeps_its_equations_to_itself() -> None:
    for kind, entry in studies().items():
        spec = entry.study
        says = spec.solves or "model" in spec.model_fields or "equations" in vars(spec) or kind in SAYS_BY_ITS_DATASET
        assert says or not entry.package.startswith("wucht."), kind


@pytest.mark.parametrize(
    ("points", "second"),
    [
        ([[0.0, 230.0], [5.0, 0.0]], " until 5 s, then without its torque"),
        ([[0.0, 230.0], [5.0, 0.0], [6.0, 230.0]], ""), ([[0.0, 230.0], [5.0, 20.0]], ""),
    ],
)  # fmt: skip
def test_a_motor_whose_voltage_a_schedule_takes_away(points: list[list[float]], second: str) -> None:
    document, path = load_document("practice/screen")
    schedule = {"parameter": "drives.e2.voltage", "points": points, "interpolation": "steps"}
    machine = machine_of({"machine": document["machine"] | {"schedules": [schedule]}}, path, "screen", {})[0]
    turning = next(x for x in assumptions(RunUp(until=9.0), machine) if "driven" in x)
    assert turning == f"e1 driven by its motor (induction); e2 driven by its motor (induction){second}"


def test_a_record_has_no_equations(tmp_path: Path) -> None:
    assert assumptions(LoadSpectrum(signal={"file": "a.csv", "column": "force"}), Records(tmp_path, "a record")) == []


def test_it_is_said_in_the_result_the_report_and_the_figure() -> None:
    start = {"p1": 0.3, "p2": -0.5}
    result = run(Response(bodies="held", start=start), load_machine(R1))
    assert result.wucht.assumed[-1] == "balancing bodies held at p1 17.19°, p2 331.4° relative to their rotor"
    told = "; ".join(result.wucht.assumed)
    assert f"  assumed      {told}" in report(result)
    assert f"assumed: {told}" in [" ".join(text.get_text().split()) for text in draw(result).texts]
    earlier = result.copy()
    del earlier.attrs["assumed"]  # one that an earlier version wrote
    assert all("assumed" not in text.get_text() for text in draw(earlier).texts)
