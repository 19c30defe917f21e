"""An orbit as it is reported, the values at which that is done, and steady states by name, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.branches import averaged_equilibria, orbit_diagram
from wucht.dynamics.branches.averaged_equilibria import AveragedEquilibria, _sides_in_line
from wucht.dynamics.branches.equilibrium_branches import StabilityLevel, stability_from_fraction, stability_levels
from wucht.dynamics.branches.orbit_branches import StoredOrbit
from wucht.dynamics.branches.orbit_diagram import _exponents, _values_to_report, reported_orbit
from wucht.dynamics.branches.second_parameter import crossing_pieces
from wucht.dynamics.branches.steady_states import Kind
from wucht.files.building import machine_from
from wucht.numerics.collocation.mesh import Mesh

PERIOD = 4.0


def stored() -> StoredOrbit:
    """(cos, sin) over a period."""
    mesh = Mesh(np.linspace(0.0, 1.0, 41), 4)
    turn = 2 * math.pi * mesh.nodes
    return StoredOrbit(mesh, np.column_stack([np.cos(turn), np.sin(turn)]), PERIOD, 0.5, "fold")


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("shown", [True, False])
def test_an_orbit_as_it_is_reported(monkeypatch: pytest.MonkeyPatch, sense: float, shown: bool) -> None:
    """The speed is 10 + 3 cos, the amplitude 2 + sin: the rotor makes 40 rad in a period."""
    monkeypatch.setattr(orbit_diagram, "cycles_of", lambda *_: None)
    monkeypatch.setattr(orbit_diagram, "_exponents", lambda *_: (np.array([-1.0]), 1e-9))

    def observables(states: np.ndarray, value: float) -> np.ndarray:
        assert value == 0.75
        return np.array([sense * (10 + 3 * states[0]), 2 + states[1]])

    subject: Any = SimpleNamespace(observables=observables, shows_rotor_speed=shown)
    found = reported_orbit(subject, SimpleNamespace(winding=None, scale=None, longest=9.0), [stored()], 0.75)  # type: ignore[arg-type]
    assert (found.value, found.period, found.kind, found.along) == (0.75, PERIOD, "fold", 1e-9)
    assert (found.low, found.high) == pytest.approx((7.0, 13.0) if sense > 0 else (-13.0, -7.0), abs=1e-6)
    assert (found.least, found.largest) == pytest.approx((1.0, 3.0), abs=1e-6)
    tau = np.linspace(0.0, 1.0, len(found.ordinate))
    assert found.ordinate == pytest.approx(sense * (10 + 3 * np.cos(2 * math.pi * tau)), abs=1e-5)
    assert found.amplitude == pytest.approx(2 + np.sin(2 * math.pi * tau), abs=1e-5)
    if shown:
        assert found.period_phi == pytest.approx(40.0, rel=1e-9)
        angle = PERIOD * (10 * tau + 3 * np.sin(2 * math.pi * tau) / (2 * math.pi))
        assert found.rotor_angle == pytest.approx(angle, abs=1e-2) and found.rotor_angle[0] == 0.0
    else:
        assert math.isnan(found.period_phi) and np.isnan(found.rotor_angle).all()


def test_exponents_are_logarithms_over_the_period_the_largest_first(monkeypatch: pytest.MonkeyPatch) -> None:
    across = np.diag(np.exp([-4.0, 2.0, -1.0]))[None]

    def maps(system: Any, parameters: Any, times: np.ndarray, states: np.ndarray) -> tuple[None, None]:
        assert times == pytest.approx(PERIOD * np.linspace(0.0, 1.0, 41)) and states.shape == (2, 41)
        assert parameters == {"a": 1.0, "p": 0.75}
        return None, None

    monkeypatch.setattr(orbit_diagram, "integrated_maps", maps)
    monkeypatch.setattr(orbit_diagram, "transverse_maps", lambda *_: (across, 1e-9))
    subject: Any = SimpleNamespace(system=None, values={"a": 1.0, "p": 0.5}, path="p")
    values, along = _exponents(subject, stored(), 0.75)
    assert values.real == pytest.approx([0.5, -0.25, -1.0]) and along == 1e-9


def test_by_default_the_middles_of_tenths_are_reported() -> None:
    """And special orbits, in order."""
    regular = [SimpleNamespace(value=v, kind="") for v in (0.0, 10.0)]
    torus = SimpleNamespace(value=4.9, kind="torus")
    stored_orbits = [regular[0], torus, regular[1]]
    branch: Any = SimpleNamespace(values=np.array([10.0, 0.0, 4.0]), stored_orbits=stored_orbits)
    case: Any = SimpleNamespace(values=None)
    targets = _values_to_report(case, branch)
    assert [value for value, _ in targets] == pytest.approx([0.5, 1.5, 2.5, 3.5, 4.5, 4.9, 5.5, 6.5, 7.5, 8.5, 9.5])
    assert targets[5][1] == (torus,) and targets[6][1] == (regular[1], regular[0])
    assert [value for value, _ in _values_to_report(SimpleNamespace(values=(3.0,)), branch)] == [3.0, 4.9]  # type: ignore[arg-type]


def states(sense: float = 1.0, second: float = 0.05) -> AveragedEquilibria:
    ball = {"kind": "pendulum", "about": "d", "length": 0.1, "damping": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 5.0},
        "bodies": [
            {"kind": "rotor", "name": "d", "mass": 1.0, "unbalance": 4e-3, "inertia": 0.01}, ball | {"name": "p", "mass": 0.05},
            ball | {"name": "q", "mass": second},
        ],
        "drive": {"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": sense * 300.0},
    })  # fmt: skip
    return AveragedEquilibria.of(machine, "d.unbalance", (1e-3, 9e-3))


@pytest.mark.parametrize(
    ("first", "second", "psi", "delta"),
    [(1.0, 0.5, 0.75, 0.5), (0.5, 1.0, 0.75, -0.5), (6.0, 0.25, 3.125 - math.pi, 5.75 - 2 * math.pi), (3.5, 3.0, None, 0.5)],
)
@pytest.mark.parametrize("equal", [True, False])
def test_steady_states_by_name(first: float, second: float, psi: float | None, delta: float, equal: bool) -> None:
    """psi is the mean of the phases, in (-pi, pi], delta their difference; of equal bodies without its sign."""
    of = states(second=0.05 if equal else 0.06)
    values = {"p.phase": first, "q.phase": second, "d.speed": 200.0}
    unknowns = np.array([*(values.get(n, 0.0) for n in of.names), 4e-3])
    found = of.state_by_name(unknowns)
    assert found["p.phase"] == pytest.approx(first) and found["q.phase"] == pytest.approx(second)
    assert found["delta"] == pytest.approx(abs(delta) if equal else delta)
    mean = second + delta / 2 if psi is None else psi
    assert math.remainder(found["psi"] - mean, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert -math.pi < found["psi"] <= math.pi


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_speed_is_drawn_with_its_sign(sense: float) -> None:
    of = states(sense)
    speed = [200.0 if n == "d.speed" else 0.5 for n in of.names]
    point = np.array([*speed, 4e-3])[:, None]
    assert of.ordinate(point) == pytest.approx([sense * 200.0]) and of.amplitude(point)[0] > 0
    assert of.fastest == pytest.approx(300.0, rel=1e-2) and of.limits == pytest.approx((1e-3 * of.fastest, 1.01 * of.fastest))


def test_bodies_in_line_and_their_sides() -> None:
    torques: Any = SimpleNamespace(size=4, is_coaxial=True, coefficients=np.array([1.0, 2.0, -1.0, 3.0]))
    assert _sides_in_line(torques, np.array([0.0, 0.5, 0.5, 0.5 + math.pi])) == (0, 1, 1)
    assert _sides_in_line(torques, np.array([0.0, 0.5, 0.5 + math.pi, 0.5])) == (0, 0, 0)
    assert _sides_in_line(torques, np.array([0.0, 0.5, 0.6, 0.5])) == ()
    torques.is_coaxial = False
    assert _sides_in_line(torques, np.array([0.0, 0.5, 0.5, 0.5])) == ()
    for size, sides in ((2, ()), (3, (0, 1))):
        few: Any = SimpleNamespace(size=size, is_coaxial=True, coefficients=np.array([1.0, 2.0, 3.0])[:size])
        assert _sides_in_line(few, np.array([0.0, 0.5, 0.5 + math.pi])[:size]) == sides


def test_levels_of_stability() -> None:
    """Growth counts relative to the fastest of the exponents."""
    exponents = np.array([[-1.0, 1.0, 1e-14, -1e-14, np.nan], [-2.0, -2.0, -2.0, -2.0, -2.0]], complex)
    expected = [StabilityLevel.STABLE, StabilityLevel.UNSTABLE, StabilityLevel.NEUTRAL, StabilityLevel.NEUTRAL]
    assert stability_levels(exponents).tolist() == [*expected, StabilityLevel.STABLE]
    assert [stability_from_fraction(s) for s in (0.0, 0.25, 1.0)] == [
        StabilityLevel.UNSTABLE, StabilityLevel.PARTLY_STABLE, StabilityLevel.STABLE,
    ]  # fmt: skip


def test_pieces_of_lines_that_cross() -> None:
    """A zigzag and a level line at 0.5, up to 2.25; beyond its end nothing crosses."""
    zigzag = np.array([[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 1.0]])
    level = np.array([[-1.0, 1.0, 2.25], [0.5, 0.5, 0.5]])
    assert crossing_pieces(zigzag, level) == [(0, 0), (1, 1)]
    assert crossing_pieces(level, zigzag) == [(0, 0), (1, 1)]


def test_states_are_compared_with_the_torques_at_their_value(monkeypatch: pytest.MonkeyPatch) -> None:
    of = states()
    u = np.array([*(200.0 if n == "d.speed" else 0.5 for n in of.names), 4e-3])
    monkeypatch.setattr(averaged_equilibria, "is_same_state", lambda torques, a, b: (torques, a.speed, b.speed))
    faster = u + [1.0 if n == "d.speed" else 0.0 for n in (*of.names, "")]
    assert of.is_same(u, faster) == (of.model_at(4e-3).torques, 200.0, 201.0)


def test_a_point_is_that_of_a_state_and_back() -> None:
    """Phases relative to the main rotor, within a turn."""
    of = states()
    u = of.point(State(150.0, np.array([0.0, 0.75, 5.5])), 4e-3)
    numbers = dict(zip(of.names, u[:-1], strict=True))
    assert u[-1] == 4e-3 and numbers["d.speed"] == pytest.approx(150.0)
    assert numbers["p.phase"] == pytest.approx(0.75) and math.remainder(numbers["q.phase"] - 5.5, 2 * math.pi) == pytest.approx(
        0.0
    )
    back = of.state(u)
    assert back.speed == pytest.approx(150.0) and back.phases == pytest.approx([0.0, 0.75, 5.5])
    assert of.ordinate_size == of.fastest and of.equilibria.equations.scale[-1] == pytest.approx(8e-3)
    second = of.equations_with("p.mass", 0.5)
    assert second.parameter_names == ("d.unbalance", "p.mass") and second.scale[-2:] == pytest.approx([8e-3, 0.5])
    rows = [i for i, n in enumerate(of.names) if n == "d.speed"]
    assert of.equilibria.limits == {rows[0]: of.limits} and of.equilibria.bounds == (1e-3, 9e-3)


def test_names_of_steady_states_at_a_value_of_the_unbalance() -> None:
    """By the phases of both bodies; whether they compensate the unbalance depends on its value, 4 or 8 of 10 g m."""
    of, half, most = states(), math.acos(-0.4), math.acos(-0.8)

    def kind(first: float, second: float, value: float = 4e-3, of: AveragedEquilibria = of) -> Kind:
        return of.kind(of.point(State(150.0, np.array([0.0, first, second])), value))

    assert kind(1.0, 1.0) == kind(math.pi, math.pi) == Kind("together", "II", (2, 0), 1)
    assert kind(0.0, math.pi) == kind(math.pi, 0.0) == Kind("opposed", "III", (1, 1), 2)
    assert kind(half, -half) == kind(most, -most, 8e-3) == Kind("compensating", "I", None, 2)
    assert kind(half, -half, 8e-3) == kind(most, -most) == kind(1.0, 2.0) == Kind(None, None, None, 2)
    assert kind(math.pi, 0.0, of=states(second=0.06)) == Kind("opposed", None, (1, 1), 1)
