"""O. Drozdetskaya, dissertation, KIT Karlsruhe 2020, section 6.2: the exciter with one pendulum and with two.

cases.md: "with one pendulum and s = 1 as printed no modulated motion is found; the delta = 0 equations of two pendulums do
modulate for mu = 0.1, w = 0.899, lambda = 2: u from 2.150 to 5.161".
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht import RunUp, run
from wucht.analysis.dimensionless import dimensionless_numbers
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.program import Evaluator
from wucht.studies.study_file import read_study

TWO = "drozdetskaya-2020/figure-6.7b"
ONE = "drozdetskaya-2020/figure-6.7-one-pendulum"
RIG, RIG_OF_TWO = "practice/exciter", "practice/exciter-two-pendulums"
HEAVY = {"mu": 0.2, "s": 0.5, "w": 2 * 0.899}  # the two pendulums of figure 6.7b as one of twice the mass


def rates(machine: Machine, state: dict[str, float]) -> dict[str, float]:
    """The rates of change at a state, by name."""
    names = machine.state_names
    x = np.array([[state[n]] for n in names])
    found = Evaluator.of_rates(machine.system).array(np.zeros(1), x, machine.system.values(machine.values))[:, 0]
    return dict(zip(names, found.tolist(), strict=True))


@pytest.mark.parametrize("seed", range(3))
def test_one_pendulum_of_twice_the_mass_is_two_that_stay_together(seed: int) -> None:
    """Lengths are in units of m r/M*, which are twice as long with the heavy pendulum."""
    of_two, of_one = load_machine(TWO), load_machine(ONE).with_unchecked_values({**HEAVY, "u": load_machine(TWO).values["u"]})
    random = np.random.default_rng(seed)
    carrier = {n: random.normal() for n in of_two.state_names if n.startswith("carrier")}
    turning = {f"{b}.{key}": random.normal() for b in ("rotor", "p1") for key in ("angle", "speed")}
    both = {**carrier, **turning, "p2.angle": turning["p1.angle"], "p2.speed": turning["p1.speed"]}
    alone = {n: x / 2 if n.startswith("carrier") else x for n, x in both.items()}
    two, one = rates(of_two, both), rates(of_one, alone)
    for name, rate in one.items():
        assert rate * (2 if name.startswith("carrier") else 1) == pytest.approx(two[name], rel=1e-12, abs=1e-13), name
    assert two["p2.speed"] == pytest.approx(two["p1.speed"], rel=1e-12)


def test_the_rig_and_its_dimensionless_numbers_are_one_machine() -> None:
    """Of (4.8) with n = 1: k = 153.9 rad/s, lengths in units of m r/M*; and such a machine is warned of nothing."""
    rig = load_machine(RIG)
    scaled = dimensionless_numbers(rig)
    model = machine_from({"model": "exciter", "parameters": {n: x for n, x in scaled.items() if n != "p"}})
    assert model.warnings == ()
    assert (scaled["s"], scaled["p"]) == pytest.approx((0.4, 1.0))
    k, length = np.sqrt(450e3 / 19), 0.01 / 19
    state = {"carrier.x": 1e-3, "carrier.y": -4e-4, "carrier.vx": 0.1, "carrier.vy": 0.2}
    state |= {"rotor.angle": 0.3, "rotor.speed": 130.0, "p1.angle": -0.8, "p1.speed": 125.0}
    units = {"carrier.x": length, "carrier.vx": length * k, "carrier.y": length, "carrier.vy": length * k}
    units |= {"rotor.angle": 1.0, "p1.angle": 1.0, "rotor.speed": k, "p1.speed": k}
    in_si = rates(rig, state)
    in_tau = rates(model, {n: x / units[n] for n, x in state.items()})
    for name, rate in in_tau.items():
        assert rate * units[name] * k == pytest.approx(in_si[name], rel=1e-11), name


def test_a_set_that_is_no_machine_is_told_with_what_would_be_right() -> None:
    """One pendulum: mu s beta_r = epsilon w beta_p, s w = 1 - mu/p. The printed set breaks the first, and keeps the second."""
    [sentence] = load_machine(ONE).warnings
    assert "mu s beta_r = 0.02, epsilon w beta_p = 0.01798" in sentence
    right = machine_from({"model": "exciter", "parameters": {**load_machine(ONE).values, "beta_r": 0.179797979797980}})
    assert right.warnings == ()
    heavy = machine_from({"model": "exciter", "parameters": {**load_machine(ONE).values, **HEAVY}})
    assert any("requires p = 1.98" in each for each in heavy.warnings)


@pytest.mark.parametrize(
    "slope, outcome",
    [(0.9e-4, "captured"), (5e-4, "captured-modulated"), (1.2e-3, "captured-modulated"), (5e-3, "passed")],
)
def test_the_full_equations_of_the_rig_modulate_where_the_averaged_ones_do(slope: float, outcome: str) -> None:
    """By the averaged ones from 1.1244e-4 to 3.0648e-3 N m s."""
    asked = RunUp(until=100.0)
    summary = run(asked, load_machine(RIG, {"drive.slope": slope})).wucht.summary
    assert summary["outcome"] == outcome
    assert summary["energy_residual"] < 1e-9


@pytest.fixture(scope="module")
def answers() -> dict[str, dict[str, Any]]:
    found = {}
    for name in (RIG, RIG_OF_TWO):
        study = read_study(name)
        found[name] = run(study.spec, study.subject).wucht.summary
    return found


@pytest.mark.slow
def test_existence_and_stability_of_the_rigs_modulated_motion(answers: dict[str, dict[str, Any]]) -> None:
    """A saddle-node on the orbit below, a fold above, from where the branch goes back to a saddle connection."""
    summary = answers[RIG]
    kinds = {e["kind"]: e["drive.slope"] for e in summary["ends"]}
    assert kinds == {
        "saddle-node-on-orbit": pytest.approx(1.124373e-4, rel=1e-5),
        "saddle-connection": pytest.approx(2.015617e-3, rel=1e-5),
    }
    assert [(p["kind"], p["drive.slope"]) for p in summary["special_points"]] == [
        ("fold", pytest.approx(3.064785e-3, rel=1e-5))
    ]
    assert summary["branches"][0]["stable"] == [pytest.approx([1.124373e-4, 3.064785e-3], rel=1e-5)]
    at = next(o for o in summary["orbits"] if o["drive.slope"] == 1.2e-3)
    assert at["period"] == pytest.approx(1.128555, rel=1e-5)
    # The averaged equations are those of a small unbalance: the full ones beat more slowly by 4.9 %.
    assert [at["min_amplitude"], at["max_amplitude"]] == pytest.approx([0.783e-3, 1.779e-3], rel=1e-2)
    full = run(RunUp(until=60.0), load_machine(RIG)).wucht.summary
    assert full["modulation_period"] == pytest.approx(at["period"], rel=0.06)


@pytest.mark.slow
def test_two_pendulums_do_the_same_until_they_part(answers: dict[str, dict[str, Any]]) -> None:
    one, two = answers[RIG], answers[RIG_OF_TWO]
    for a, b in zip(one["ends"], two["ends"], strict=True):
        assert a["drive.slope"] == pytest.approx(b["drive.slope"], rel=1e-6)
    points = {p["kind"]: p["drive.slope"] for p in two["special_points"]}
    assert points["branch-point"] == pytest.approx(2.745667e-3, rel=1e-5)
    assert points["fold"] == pytest.approx(one["special_points"][0]["drive.slope"], rel=1e-6)
    assert two["branches"][0]["stable"] == [pytest.approx([1.124373e-4, 2.745667e-3], rel=1e-5)]


def test_one_pendulum_as_printed_does_not_modulate() -> None:
    study = read_study(ONE)
    summary = run(study.spec, study.subject).wucht.summary
    assert summary["orbits"] == []
    assert [t["found"].split(" ", 4)[4] for t in summary["tried"]] == ["it settles in a steady state"] * 5


def test_one_pendulum_of_twice_the_mass_has_the_limits_of_two() -> None:
    """The numbers of cases.md, by the other machine."""
    study = read_study(ONE, {**HEAVY, "study.range": [1.0, 8.0], "study.at": 4.0, "study.inertia": False})
    summary = run(study.spec, study.subject).wucht.summary
    limits = sorted(e["u"] for e in summary["ends"])
    assert limits == [pytest.approx(2.150317, abs=1e-5), pytest.approx(5.161263, abs=1e-5)]
    assert summary["branches"][0]["stable"] == [pytest.approx(limits, abs=1e-6)]
