"""The limits of the keys of all studies: the last allowed value on either side, and the first that is not."""

from __future__ import annotations

import math
from typing import Any

import pytest

from wucht import (
    Activation,
    Approximation,
    Basin,
    CamContour,
    CamCorrection,
    CamLaw,
    CamPrediction,
    CaptureProbability,
    CoastDown,
    Comparison,
    Entrainment,
    ExciterDesign,
    FailureDetection,
    InputError,
    LoadSpectrum,
    OptimiseBalancer,
    OrbitBranch,
    PhasePortrait,
    Response,
    RunUp,
    SpeedCurve,
    StabilityMap,
    Sweep,
    SynchronousStates,
    TorqueBalance,
)

BASE: dict[Any, dict[str, Any]] = {
    Activation: {"until": 1.0},
    Approximation: {"along": "a", "range": [1, 2]},
    Basin: {"axes": {"psi": [0, 1, 2], "delta": [0, 1, 2]}},
    CamContour: {}, CamCorrection: {}, CamLaw: {}, CamPrediction: {},
    CaptureProbability: {"along": "a", "range": [0, 1], "random": {"psi": {"uniform": [0, 1]}, "delta": {"uniform": [0, 1]}}},
    CoastDown: {}, Entrainment: {},
    ExciterDesign: {"target": [[1, 1e6], [2, 1e3]], "vary": {"mass": [1, 2]}, "population": 4, "reach": 2000,
        "evaluations": 2000},
    FailureDetection: {
        "until": 100.0, "sensor": {"interval": 1.0, "noise": 1.0, "false_alarm_every": 3600.0}, "along": "a", "range": [0, 1],
        "second": "b", "second_range": [0, 1],
    },
    LoadSpectrum: {"until": 8.0},
    OptimiseBalancer: {"vary": {"mass": [1, 2]}, "population": 4, "samples": 2, "evaluations": 1000},
    OrbitBranch: {"along": "a", "range": [0, 1]},
    PhasePortrait: {}, Response: {}, RunUp: {},
    SpeedCurve: {"along": "a", "range": [0, 1]},
    StabilityMap: {"along": "a", "range": [0, 1], "second": "b", "second_range": [0, 1]},
    Sweep: {"along": "a", "range": [0, 1]},
    SynchronousStates: {}, TorqueBalance: {},
}  # fmt: skip

WHOLE: list[tuple[Any, str, int, int]] = [
    (Activation, "phases", 1, 360), (Approximation, "points", 2, 200), (Basin, "refine", 0, 10), (CamLaw, "orders", 1, 500),
    (CamContour, "points", 16, 1_000_000), (CamContour, "decimals", 0, 12), (CamCorrection, "points", 36, 20_000),
    (CamCorrection, "orders", 1, 250), (CamCorrection, "decimals", 0, 12), (CamLaw, "points", 16, 1_000_000),
    (CamPrediction, "points", 16, 100_000), (CamPrediction, "orders", 1, 200), (CamPrediction, "cuts", 0, 50),
    (CamPrediction, "simulate", 0, 1000), (CamPrediction, "speed_points", 2, 10_000), (CaptureProbability, "points", 2, 1000),
    (Entrainment, "points", 5, 2000), (ExciterDesign, "population", 4, 1000), (ExciterDesign, "candidates", 1, 20),
    (ExciterDesign, "corrections", 0, 10), (ExciterDesign, "polish", 0, 10_000), (ExciterDesign, "samples", 0, 10_000),
    (ExciterDesign, "beats", 2, 10_000), (ExciterDesign, "evaluations", 4, 100_000), (ExciterDesign, "reach", 4, 100_000),
    (ExciterDesign, "seed", 0, 2**31), (FailureDetection, "points", 2, 200), (FailureDetection, "second_points", 2, 200),
    (OptimiseBalancer, "samples", 2, 4096), (OptimiseBalancer, "evaluations", 4, 1_000_000),
    (OptimiseBalancer, "population", 4, 1000), (OptimiseBalancer, "points", 1, 100), (OptimiseBalancer, "seed", 0, 2**31),
    (PhasePortrait, "trajectories", 0, 400), (Response, "points", 2, 100_000), (SpeedCurve, "points", 1, 200),
    (StabilityMap, "cells", 2, 64), (TorqueBalance, "points", 2, 100_000),
]  # fmt: skip


def refused_at(spec: Any, key: str, value: Any, **more: Any) -> bool:
    """Whether this value of a key is refused at that key, or else allowed."""
    try:
        spec(**BASE[spec] | more | {key: value})
    except InputError as error:
        assert error.key.startswith(f"study.{key}"), error
        return True
    return False


def name(value: Any) -> str:
    return str(getattr(value, "kind", value))


@pytest.mark.parametrize(("spec", "key", "low", "high"), WHOLE, ids=name)
def test_whole_numbers(spec: Any, key: str, low: int, high: int) -> None:
    assert [refused_at(spec, key, n) for n in (low - 1, low, high, high + 1)] == [True, False, False, True]


POSITIVE = [
    (Activation, "until"), (CamContour, "chord_tolerance"), (CamContour, "spacing"), (CamContour, "wheel_radius"),
    (CamContour, "speed"), (CamCorrection, "chord_tolerance"), (CoastDown, "until"), (Entrainment, "until"),
    (ExciterDesign, "slope"), (FailureDetection, "learning"), (LoadSpectrum, "until"), (Approximation, "until"),
    (Approximation, "until_phi"), (Basin, "until"), (OptimiseBalancer, "until"), (OrbitBranch, "until"),
    (OrbitBranch, "longest"), (PhasePortrait, "length"), (RunUp, "until"), (RunUp, "turns"), (RunUp, "speed_limit"),
]  # fmt: skip


@pytest.mark.parametrize(("spec", "key"), POSITIVE, ids=name)
def test_what_must_be_positive(spec: Any, key: str) -> None:
    assert [refused_at(spec, key, x) for x in (-1.0, 0.0, 1e-3)] == [True, True, False]


@pytest.mark.parametrize(
    ("spec", "key", "allowed", "not_allowed"),
    [
        (CaptureProbability, "probability", (0.001, 0.999), (0.0, 1.0)),
        (CaptureProbability, "confidence", (0.001, 0.999), (0.0, 1.0)),
        (CaptureProbability, "seed", (0, 5), (-1,)),
        (CaptureProbability, "samples", (8, 48, 64, 80, 2**20), (7, 72, 2**20 + 16)),
        (ExciterDesign, "spread", (0.0, 0.999), (-0.001, 1.0)),
        (FailureDetection, "after", (0.0, 99.0), (-0.001, 100.0)),
        (LoadSpectrum, "after", (0.0, 7.999), (-0.001, 8.0)),
        (PhasePortrait, "length", (1000.0,), (1000.1,)),
        (PhasePortrait, "seed", (0,), (-1,)),
        (PhasePortrait, "trajectories", ([{"x": 1}] * 400, 3.0), ([{"x": 1}] * 401, 3.5, True)),
        (PhasePortrait, "together", (True, ["a", "b"]), (False, ["a"], ["a", 1])),
        (PhasePortrait, "ranges", ({"x": [0, 1]},), ({"x": [0]}, {"x": [0, 1, 2]}, {"x": 1}, [1, 2])),
        (Response, "range", ([0.0, 1.0],), ([-0.001, 1.0], [1.0, 1.0])),
        (RunUp, "stored_samples", (2,), (1, 0)),
        (RunUp, "deck", (-1.499, 1.499), (-1.5, 1.5)),
        (RunUp, "tolerance", (1e-16, 1e-2), (0.9e-16, 1.1e-2)),
        (RunUp, "order", (), (0, 3, True)),
        (Sweep, "jump_tolerance", (1e-8, 0.1), (0.9e-8, 0.11)),
        (SynchronousStates, "speed", (-1.0, 1.0), (0.0,)),
        (OptimiseBalancer, "unbalance", ([1e-9, 1.0],), ([0.0, 1.0], [-1.0, 1.0], [1.0, 1.0])),
        (OptimiseBalancer, "bodies", ([1], [10, 1]), ([0], [11], [2, 2], [], [True], 3)),
        (Activation, "activation_speeds", ([0.1],), ([0.0], [1.0, 1.0], [])),
        (Activation, "orientations", ([0.0], [-1.0, 1.0]), ([1.0, 1.0], [])),
        (Activation, "variants", (["none"],), ([], ["none", "none"], ["other"])),
        (SpeedCurve, "second", (), ("a",)),
        (StabilityMap, "second", (), ("a",)),
        (OrbitBranch, "values", ([1.0],), ([],)),
        (OrbitBranch, "at", (1.0, [1.0, 2.0]), ([],)),
    ],
    ids=name,
)
def test_other_limits(spec: Any, key: str, allowed: tuple[Any, ...], not_allowed: tuple[Any, ...]) -> None:
    assert [refused_at(spec, key, x) for x in allowed] == [False] * len(allowed)
    assert [refused_at(spec, key, x) for x in not_allowed] == [True] * len(not_allowed)


@pytest.mark.parametrize(
    ("spec", "key", "axis", "most"),
    [(Basin, "axes", "psi", 2048), (SynchronousStates, "axes", "speed", 400)],
    ids=name,
)
def test_cells_of_maps(spec: Any, key: str, axis: str, most: int) -> None:
    other = {"psi": "delta", "speed": "ratio"}[axis]

    def cells(n: Any) -> dict[str, Any]:
        return {axis: [0, 1, n], other: [0, 1, 2048 if spec is Basin else 2]}

    assert [refused_at(spec, key, cells(n)) for n in (1, 2, most, most + 1, 2.5, True)] == [
        True,
        False,
        False,
        True,
        True,
        True,
    ]
    short = {axis: [0, 1], other: [0, 1, 2]}
    assert refused_at(spec, key, short) and refused_at(spec, key, {axis: [0, 1, 2]})


def test_halved_cells_count_as_the_finest_map() -> None:
    """Of 2048 by 2048 cells: 64 by 64 may be halved five times, 65 by 64 may not."""
    for columns, halvings, allowed in ((64, 5, True), (65, 5, False), (65, 4, True), (64, 6, False)):
        axes = {"psi": [0, 1, columns], "delta": [0, 1, 64]}
        try:
            Basin(axes=axes, refine=halvings)
        except InputError as error:
            assert not allowed and error.key == "study.axes"
        else:
            assert allowed, (columns, halvings)


def test_axes_of_synchronous_states_begin_at_zero_and_rise() -> None:
    def allowed(low: float, high: float, of: str = "speed") -> bool:
        other = {"speed": "ratio", "ratio": "speed"}[of]
        return not refused_at(SynchronousStates, "axes", {of: [low, high, 2], other: [0, 1, 2]})

    assert [allowed(*ends) for ends in ((0.0, 1.0), (-0.001, 1.0), (1.0, 1.0), (2.0, 1.0))] == [True, False, False, False]
    assert [allowed(0.0, high, "ratio") for high in (1e6, 1.001e6)] == [True, False] and allowed(0.0, 1e7)
    assert refused_at(SynchronousStates, "range", [1.0, 2.0], speed=3.0) and not refused_at(
        SynchronousStates, "range", [1.0, 2.0]
    )


@pytest.mark.parametrize(
    ("spec", "key"), [(ExciterDesign, "reach"), (ExciterDesign, "evaluations"), (OptimiseBalancer, "evaluations")]
)
def test_a_search_has_at_least_one_population(spec: Any, key: str) -> None:
    assert [refused_at(spec, key, n, population=50) for n in (49, 50)] == [True, False]


def test_each_number_of_bodies_has_a_population() -> None:
    given = {"population": 50, "bodies": [2, 3, 4]}
    assert [refused_at(OptimiseBalancer, "evaluations", n, **given) for n in (149, 150)] == [True, False]


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"second": "b"}, "study.second"), ({"second_values": [1.0]}, "study.second"),
        ({"second_range": [0, 1]}, "study.second"),
        ({"second": "b", "second_values": []}, "study.second_values"),
        ({"second": "b", "second_values": [1.0], "second_range": [0, 1]}, "study.second"),
    ],
)  # fmt: skip
def test_a_second_parameter_has_values_or_a_range(given: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as caught:
        SpeedCurve(**BASE[SpeedCurve] | given)
    assert caught.value.key == key
    for one in ({"second_values": [1.0]}, {"second_range": [0, 1]}):
        assert SpeedCurve(**BASE[SpeedCurve] | {"second": "b"} | one).second == "b"


def test_how_many_runs_there_may_be() -> None:
    def runs(orientations: int, phases: int, speeds: int) -> bool:
        given = {"orientations": [0.01 * k for k in range(orientations)], "activation_speeds": [1.0 + k for k in range(speeds)]}
        return not refused_at(Activation, "phases", phases, **{k: v for k, v in given.items() if v})

    assert [runs(50, 100, 0), runs(50, 101, 0), runs(5, 100, 10), runs(5, 100, 11)] == [True, False, True, False]
    values = {"along": "a", "values": [float(k) for k in range(250)]}
    assert not refused_at(RunUp, "starts", [{}, {"x": 1}], **values)
    with pytest.raises(InputError, match=r"study\.values.* 500 runs"):
        RunUp(starts=[{}, {"x": 1}], **values | {"values": [float(k) for k in range(251)]})
    assert [refused_at(PhasePortrait, "values", [1.0] * n, along="a") for n in (60, 61)] == [False, True]
    assert [refused_at(Approximation, "values", [1.0 * k for k in range(n)], range=None) for n in (0,)] == [True]
    most = 10_000_000 // 4096
    assert [refused_at(OptimiseBalancer, "evaluations", n, samples=4096) for n in (most, most + 1)] == [False, True]


@pytest.mark.parametrize(
    ("files", "values", "allowed"), [(1, 1, False), (1, 2, True), (2, 1, True), (2, 250, True), (3, 167, False)]
)
def test_how_many_variants_there_may_be(files: int, values: int, allowed: bool) -> None:
    given = {"of": [f"f{k}" for k in range(files)], "vary": {"a": list(range(values))}}
    try:
        made = Comparison(**given)
    except InputError as error:
        assert not allowed and error.key == "study.vary"
    else:
        assert allowed and len(made.combinations) == values


def test_one_or_two_keys_are_varied_and_none_that_is_set() -> None:
    made = Comparison(of=["f"], vary={"a": [1, 2], "b": {"c": [3, 4]}})
    assert made.combinations == ({"a": 1, "b.c": 3}, {"a": 1, "b.c": 4}, {"a": 2, "b.c": 3}, {"a": 2, "b.c": 4})
    for vary, key in (({"a": [1], "b": [1], "c": [1]}, "study.vary"), ({"a": []}, "study.vary.a"), ({"a": 3}, "study.vary.a")):
        with pytest.raises(InputError) as caught:
            Comparison(of=["f", "g"], vary=vary)
        assert caught.value.key == key
    with pytest.raises(InputError) as caught:
        Comparison(of=["f"], vary={"b": [1, 2], "a": [1, 2]}, set={"a": 3, "b": 4})
    assert caught.value.key == "study.vary.a", "the first by the alphabet"


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"sensitivity": True}, "study.at"), ({"at": 1.0}, "study.at"),
        ({"sensitivity_samples": 64}, "study.sensitivity_samples"),
        ({"sensitivity": True, "at": 1.0, "random": {"psi": {"uniform": [0, 1]}}}, "study.sensitivity"),
        ({"sensitivity": True, "at": 1.0, "samples": 96}, "study.samples"),
        ({"sensitivity": True, "at": 1.0, "sensitivity_samples": 96}, "study.sensitivity_samples"),
        ({"sensitivity": True, "at": 1.0, "sensitivity_samples": 32}, "study.sensitivity_samples"),
        ({"along": "psi"}, "study.random.psi"), ({"order": 2}, "study.order"), ({"inertia": True}, "study.inertia"),
    ],
)  # fmt: skip
def test_what_a_probability_refuses_of_its_sensitivity(given: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as caught:
        CaptureProbability(**BASE[CaptureProbability] | given)
    assert caught.value.key == key


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"until": 1.0, "turns": 3}, "study.until"), ({"turns": 3, "settled": True}, "study.until"),
        ({"settled": False}, "study.settled"), ({"until": {}}, "study.until"), ({"until": {"turn": 3}}, "study.until.turn"),
        ({"inertia": True}, "study.inertia"), ({"order": 1}, "study.order"),
        ({"start": {"a": 1}, "starts": [{"a": 2}]}, "study.starts"),
        ({"along": "a"}, "study.values"), ({"values": [1.0]}, "study.along"),
    ],
)  # fmt: skip
def test_keys_of_a_run_that_exclude_each_other(given: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as caught:
        RunUp(**given)
    assert caught.value.key == key


def test_what_a_run_up_is_asked_in_other_words() -> None:
    assert (RunUp(until="settled").settled, RunUp(until="settled").until) == (True, None)
    assert (RunUp(until={"turns": 30}).turns, RunUp(until={"settled": True}).settled) == (30.0, True)
    assert RunUp(settled=False, until=2.0).until == 2.0 and RunUp(settled=False, turns=2).turns == 2.0
    assert Basin(**BASE[Basin] | {"until": "settled"}).until is None
    for model in ("slow", "both"):
        settings = RunUp(model=model, order=2, inertia=False, speed_limit=7.0, turns=3.0, stored_samples=9).settings
        assert (settings.model, settings.order, settings.inertia, settings.speed_limit) == (model, 2, False, 7.0)
        assert (settings.turns, settings.until, settings.stored_samples, settings.runs) == (3.0, None, 9, 1)
    assert RunUp(starts=[{}, {}], along="a", values=[1.0, 2.0, 3.0]).settings.runs == 6


def test_a_load_spectrum_has_one_motion_and_what_its_counting_needs() -> None:
    for given, key in (
        ({"model": "both"}, "model"), ({"reference": 0.0}, "reference"),
        ({"reference": 0.0, "counting": "range-pair"}, "reference"),
        ({"counting": "peaks", "residue": "drop"}, "residue"), ({"counting": "level-crossing", "residue": "drop"}, "residue"),
        ({"signal": {"file": "a"}, "direction": "x"}, "direction"), ({"signal": {"file": "a"}, "until": 2.0}, "until"),
        ({"signal": "speed"}, "signal"), ({"signal": {"file": ""}}, "signal.file"),
    ):  # fmt: skip
        with pytest.raises(InputError) as caught:
            LoadSpectrum(**given)
        assert caught.value.key == f"study.{key}"
    for counting in ("peaks", "level-crossing"):
        assert LoadSpectrum(counting=counting, reference=0.0, residue="repeat").reference == 0.0
    assert LoadSpectrum(residue="drop").residue == "drop" and LoadSpectrum().record is None
    record = LoadSpectrum(signal={"file": "a", "column": "b"}).record
    assert record is not None and (record.file, record.column) == ("a", "b")


def test_kinds_of_wrong_values_of_common_types() -> None:
    def wrong(spec: Any, key: str, *values: Any) -> list[bool]:
        return [refused_at(spec, key, v) for v in values]

    assert wrong(SpeedCurve, "along", "", "  ", 3) == [True] * 3
    assert wrong(SpeedCurve, "range", [1], [1, 2, 3], 1, [True, 2]) == [True] * 4
    assert (
        wrong(Response, "points", 5.5, True, "5", math.inf) == [True] * 4 and wrong(Response, "points", 5.0, 5) == [False] * 2
    )
    assert wrong(RunUp, "start", [1], "x") == [True] * 2 and wrong(RunUp, "starts", {"a": 1}, [1]) == [True] * 2
    assert wrong(StabilityMap, "orbits", 1, "true") == wrong(StabilityMap, "inertia", 1, "true") == [True] * 2
