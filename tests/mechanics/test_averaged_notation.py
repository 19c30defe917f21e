"""The averaged equations as they are printed: every symbol means one thing, and comes before its use."""

from __future__ import annotations

import re

import pytest

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.machines.operation import has_damped_balancers
from wucht.machines.symbols import notation_of
from wucht.mechanics.notation import equation_text, printed_averaged_equations

MACHINES = (
    "drozdetskaya-2020/table-3.1-carrier",
    "drozdetskaya-2020/table-5.1",
    "drozdetskaya-2020/r1",
    "practice/screen",
    "sperling-rollers/figure-8",
    "sperling-vibration/figure-2a",
)
KNOWN_FUNCTIONS = r"\b(cos|sin|sqrt|pi|Abs|sign|tanh|signedsquare)\b"


def written(machine: Machine, inertia: bool | None = None, order: int = 1, latex: bool = False) -> tuple[list[str], list[str]]:
    with_inertia = not has_damped_balancers(machine) if inertia is None else inertia
    zero = [s for s, v in machine.numbers.items() if v == 0]
    rows, definitions = printed_averaged_equations(
        averaged_equations_of(machine, with_inertia, order).averaged_system, notation_of(machine), zero, latex
    )
    return [equation_text(e, latex) for e in rows], [equation_text(e, latex) for e in definitions]


def left_over(expression: str, known: set[str]) -> str:
    """What is no known name, function, number or operator."""
    for name in sorted(known, key=len, reverse=True):
        expression = re.sub(rf"(?<![\w.]){re.escape(name)}(?![\w.'])", " ", expression)
    expression = re.sub(KNOWN_FUNCTIONS, " ", expression)
    return re.sub(r"[\d.\s+\-*/(),]|\be-?\d+", "", expression)


def states(machine: Machine, parameters: set[str]) -> set[str]:
    speed = next(n for n in ("omega", "Omega", "w", "n") if n not in parameters)
    phase = next(n for n in ("alpha", "psi") if n not in parameters)
    bodies = [b.name for b in machine.bodies]
    return {speed, *(f"{letter}_{b}" for b in bodies for letter in (speed, phase))}


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", MACHINES)
def test_every_symbol_is_a_state_a_parameter_or_defined_before(name: str, order: int) -> None:
    machine = load_machine(name)
    if order == 2 and name in ("practice/laboratory-centrifuge", "practice/laundry-drum"):
        pytest.skip("many bodies: thousands of definitions of the same kinds")
    rows, definitions = written(machine, order=order)
    names = notation_of(machine).names
    parameters = {names[path] for path in machine.values if machine.values[path]}
    known = parameters | states(machine, parameters | set(names.values()))
    for line in definitions:
        left, right = line.split(" = ")
        assert not left_over(right, known), f"{left} = {right}"
        assert left not in known, f"{left} has two meanings"
        known.add(left)
    rates = {f"{s}'" for s in states(machine, set(names.values()))}
    for line in rows:
        left, right = line.split(" = ")
        assert not left_over(left, known | rates), line
        written_rates = set(re.findall(r"[\w.]+'", left))
        # On the right stands no rate but those that the rows give: that of a prescribed speed is given by the drive.
        given = {m for row in rows for m in re.findall(r"[\w.]+'", row.split(" = ")[0])}
        assert not left_over(right, known | given), line
        assert written_rates


@pytest.mark.parametrize("latex", [False, True])
def test_the_rotor_on_a_carrier_as_001_prints_it(latex: bool) -> None:
    """001 (60), Bild 5: J w' = U (w_0 - w) + V, with b_M for the slope U; with the response of one direction."""
    rows, definitions = written(load_machine("sperling-vibration/figure-5"), latex=latex)
    if not latex:
        assert rows == ["J*omega' = V_rotor + b_M*(-omega + omega_0)"]
        assert definitions == [
            "U_rotor = M*e",
            "Re(D_x) = c - omega**2*(M + m)",
            "Im(D_x) = b*omega",
            "|D|^2_x = Im(D_x)**2 + Re(D_x)**2",
            "Im(H_x) = -Im(D_x)/|D|^2_x",
            "Im(z_x) = Im(H_x)*U_rotor*omega**2",
            "V_rotor = Im(z_x)*U_rotor*omega**2/2",
        ]
    else:
        assert rows == [r"J \dot{\omega} &= V_{\mathrm{rotor}} + b_{\mathrm{M}} \left(- \omega + \omega_{\mathrm{0}}\right)"]


def test_the_entrained_rotor_as_001_prints_it() -> None:
    """001 (16), (20): alpha' = w - Omega, J w' = L - (1/2) m eps x_0 Omega^2 sin alpha."""
    rows, definitions = written(load_machine("sperling-vibration/figure-2a"))
    assert rows == ["alpha_rotor' = -Omega + omega", "J*omega' = V_rotor + b_M*(-omega + omega_0)"]
    assert definitions == ["U_rotor = M*e", "V_rotor = -Omega**2*U_rotor*x_0*sin(alpha_rotor)/2"]
