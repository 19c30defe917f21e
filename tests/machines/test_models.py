"""Dimensionless machines: what does not follow from their energies."""

import math

import pytest
import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.models import Exciter, LavalRotor, RotorOnCarrier, SelfBalancingRotor


def value(machine: Machine, expression: sp.Expr, **states: float) -> float:
    known = machine.values | {name.replace("_", ".", 1): number for name, number in states.items()}
    return float(expression.xreplace({symbol: sp.Float(known[symbol.name]) for symbol in expression.free_symbols}))


MOVING = {"carrier_x": 0.3, "carrier_y": -0.5, "carrier_vx": 0.7, "carrier_vy": -0.4, "rotor_angle": 0.9, "rotor_speed": 1.3}
PENDULUMS = {"p1_angle": 2.0, "p1_speed": 1.1, "p2_angle": -1.0, "p2_speed": 1.6}
SIZES = {
    "epsilon": 0.02, "mu": 0.05, "s": 0.75, "w": 1.2, "beta_p": 0.3, "beta_r": 0.4, "lambda": 1.7, "sigma": 0.1, "u": 5.0,
}  # fmt: skip


ROTOR = {name: SIZES[name] for name in ("epsilon", "sigma", "lambda", "u")}


def excess(angle: float) -> float:
    """n(a) = -xi' sin a + eta' cos a."""
    return -0.7 * math.sin(angle) - 0.4 * math.cos(angle)


def test_energies_and_powers_of_a_rotor_on_a_carrier() -> None:
    """002 (3.59)-(3.61): T = (xi'^2 + eta'^2)/2 + phi' n(phi) + phi'^2/(2 epsilon); and in x alone, (3.33)."""
    laval = Machine(LavalRotor.model_validate(ROTOR))
    system = laval.system
    kinetic = (0.49 + 0.16) / 2 + 1.3 * excess(0.9) + 1.69 / 0.04
    assert value(laval, system.output("stored_energy").expression, **MOVING) == pytest.approx(kinetic + (0.09 + 0.25) / 2)
    assert value(laval, system.output("dissipated_work").expression, **MOVING) == pytest.approx(2 * 0.1 * (0.49 + 0.16))
    assert value(laval, system.output("supplied_work").expression, **MOVING) == pytest.approx(5 * (1.7 - 1.3) * 1.3)
    assert value(laval, system.output("motor_torque").expression, **MOVING) == pytest.approx(5 * (1.7 - 1.3))
    along_x = Machine(RotorOnCarrier.model_validate(ROTOR))
    kinetic = 0.49 / 2 - 1.3 * 0.7 * math.sin(0.9) + 1.69 / 0.04
    assert value(along_x, along_x.system.output("stored_energy").expression, **MOVING) == pytest.approx(kinetic + 0.09 / 2)


@pytest.mark.parametrize("count", [1, 2])
def test_energies_and_powers_with_pendulums(count: int) -> None:
    """The formula at the head of the module, with the torques of the dampers as they are printed."""
    machine = Machine((Exciter if count == 1 else SelfBalancingRotor).model_validate(SIZES))
    kinetic = (0.49 + 0.16) / 2 + 0.75 * 1.3 * excess(0.9) + 0.75 * 1.69 / (2 * 0.02 * 1.2)
    lost = 2 * 0.1 * (0.49 + 0.16)
    for angle, speed in ((2.0, 1.1), (-1.0, 1.6))[:count]:
        kinetic += speed * excess(angle) + speed**2 / (2 * 0.05)
        lost -= 0.3 / 0.05 * (1.3 - speed) * speed + 0.75 * 0.4 / (count * 0.02 * 1.2) * (speed - 1.3) * 1.3
    at, system = MOVING | PENDULUMS, machine.system
    assert value(machine, system.output("stored_energy").expression, **at) == pytest.approx(kinetic + (0.09 + 0.25) / 2)
    assert value(machine, system.output("dissipated_work").expression, **at) == pytest.approx(lost)
    motor = 0.75 * 5 / 1.2 * (1.7 - 1.3)
    assert value(machine, system.output("motor_torque").expression, **at) == pytest.approx(motor)
    assert value(machine, system.output("supplied_work").expression, **at) == pytest.approx(motor * 1.3)


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize(
    ("changes", "doubts"),
    [
        ({}, []),
        ({"beta_r": 1 + 1e-5}, ["beta_r = "]),
        ({"beta_r": 1 - 1e-5}, ["beta_r = "]),
        ({"mu": 1.01}, ["requires p = "]),
        ({"mu": 0.5}, []),
        ({"w": 1.5}, ["requires p = none"]),
    ],
)
def test_parameters_that_no_machine_has(count: int, changes: dict[str, float], doubts: list[str]) -> None:
    """s w = 1 - n mu/p with p up to 1, and mu s beta_r = n epsilon w beta_p; each number times a factor."""
    sizes = SIZES | {"s": 0.75, "w": 1.2, "mu": 0.1 / count}  # s w = 0.9, so that p = 1
    sizes |= {name: factor * sizes[name] for name, factor in changes.items() if name != "beta_r"}
    sizes["beta_r"] = count * 0.02 * sizes["w"] * 0.3 / (sizes["mu"] * sizes["s"]) * changes.get("beta_r", 1.0)
    model = (Exciter if count == 1 else SelfBalancingRotor).model_validate(sizes)
    assert len(model.warnings()) == len(doubts)
    assert all(doubt in sentence for doubt, sentence in zip(doubts, model.warnings(), strict=True))
    if changes.get("beta_r"):
        right = count * 0.02 * 1.2 * 0.3 / (0.1 / count * 0.75)
        assert f"beta_r = {right:.6g} would be right" in model.warnings()[0]
