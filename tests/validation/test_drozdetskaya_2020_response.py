"""Steady forced vibration and working points: O. Drozdetskaya, dissertation, KIT Karlsruhe 2020 (source 002), 2.2.1 and 3.2.

The closed forms (2.74)-(2.79) and what follows from them by hand; (2.79) with its missing factor M (errata). Where a case has
no closed form (two stiffnesses, a rigid body on mounts, a foundation), against the full equations integrated until their start
has died away. Tolerance of the closed forms 1e-12 relative: both sides are a few operations in floating point. Tolerance of
the integration 1e-8: what is left of the start, and the error of the engine at 1e-12 a step, summed over the run.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht import Response, TorqueBalance, run
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

M, E, C, B = 9.75, 1e-3, 1e5, 200.0  # errata.md: the real machines R1 and R2, without pendulums
K, SIGMA = math.sqrt(C / M), B / (2 * M)  # (2.76), (2.77)
ROTOR = {"kind": "rotor", "name": "drum", "mass": M, "eccentricity": E, "inertia": 0.03}


def laval(speed: float = 200.0, **carrier: Any) -> Machine:
    return machine_from(
        {
            "carrier": {"stiffness": C, "damping": B} | carrier,
            "bodies": [ROTOR],
            "drive": {"kind": "linear", "slope": 0.05, "no_load_speed": speed},
        }
    )


@pytest.fixture(scope="module", params=[200.0, -200.0], ids=["counter-clockwise", "clockwise"])
def response(request: pytest.FixtureRequest) -> xr.Dataset:
    return run(Response(), laval(request.param))


def denominator(w: np.ndarray) -> np.ndarray:
    value: np.ndarray = (K**2 - w**2) ** 2 + 4 * SIGMA**2 * w**2
    return value


def test_displacements(response: xr.Dataset) -> None:
    """(2.74), (2.75); clockwise, y is mirrored."""
    w, sense = response.speed.values, math.copysign(1, float(response.free_speed))
    for turned in (0.0, 0.7, 2.0, 4.4):
        shape = response.displacement_real * math.cos(turned) - response.displacement_imag * math.sin(turned)
        x = E * w**2 / denominator(w) * ((K**2 - w**2) * math.cos(turned) + 2 * SIGMA * w * math.sin(turned))
        y = E * w**2 / denominator(w) * ((K**2 - w**2) * math.sin(turned) - 2 * SIGMA * w * math.cos(turned))
        scale = response.amplitude.values
        assert (shape.sel(direction="x").values - x) / scale == pytest.approx(0, abs=1e-12)
        assert (shape.sel(direction="y").values - sense * y) / scale == pytest.approx(0, abs=1e-12)


def test_radius_phase_and_torque(response: xr.Dataset) -> None:
    """(2.78), figure 2.17; the phase of (2.74); (2.79) corrected, figure 2.19."""
    w = response.speed.values
    assert response.amplitude.values == pytest.approx(E * w**2 / np.sqrt(denominator(w)), rel=1e-12)
    assert response.minor_axis.values == pytest.approx(response.amplitude.values, rel=1e-12)  # a circle, run through forward
    for direction in ("x", "y"):
        assert response.lag.sel(direction=direction).values == pytest.approx(np.arctan2(2 * SIGMA * w, K**2 - w**2), rel=1e-11)
    torque = 2 * M * E**2 * SIGMA * w**5 / denominator(w)
    assert response.vibration_torque.values == pytest.approx(torque, rel=1e-12)
    assert response.required_torque.values == pytest.approx(torque, rel=1e-12)


def test_self_centring(response: xr.Dataset) -> None:
    """Figure 2.18: |x + i y + e exp(i phi)| = e sqrt(k^4 + 4 sigma^2 w^2)/sqrt(...), nearer than e beyond sqrt(2) k."""
    w = response.speed.values
    distance = E * np.sqrt(K**4 + 4 * SIGMA**2 * w**2) / np.sqrt(denominator(w))
    assert response.centre_distance.values == pytest.approx(distance, rel=1e-11)
    # Nearer than the axis: k^4 + 4 sigma^2 w^2 < w^4
    exact = math.sqrt(2 * SIGMA**2 + math.sqrt(4 * SIGMA**4 + K**4))
    assert response.wucht.summary["self_centring_speed"] == pytest.approx(exact, rel=1e-12)


def test_peaks(response: xr.Dataset) -> None:
    """d/dw of (2.78): w^2 = k^4/(k^2 - 2 sigma^2), R = e k^2/(2 sigma sqrt(k^2 - sigma^2)); of (2.79): a quadratic in w^2."""
    s = response.wucht.summary
    assert s["critical_speeds"] == pytest.approx([K], rel=1e-14)
    at = K**2 / math.sqrt(K**2 - 2 * SIGMA**2)
    assert [p["speed"] for p in s["peaks"]] == pytest.approx([at], rel=1e-11)
    assert s["peak_speed"] == pytest.approx(at, rel=1e-11)
    assert s["peak_amplitude"] == pytest.approx(E * K**2 / (2 * SIGMA * math.sqrt(K**2 - SIGMA**2)), rel=1e-12)
    # 5 N = w N', N = w^4 + a w^2 + k^4, a = 4 sigma^2 - 2 k^2: w^4 + 3 a w^2 + 5 k^4 = 0
    a = 4 * SIGMA**2 - 2 * K**2
    hardest = math.sqrt((-3 * a - math.sqrt(9 * a**2 - 20 * K**4)) / 2)
    assert s["peak_torque_speed"] == pytest.approx(hardest, rel=1e-11)
    torque = 2 * M * E**2 * SIGMA * hardest**5 / float(denominator(np.array(hardest)))
    assert s["peak_torque"] == pytest.approx(torque, rel=1e-12)


def test_the_dimensionless_rotor_is_the_same() -> None:
    """With x = e xi and t = tau/k; torques in M e^2 k^2."""
    machine = load_machine("drozdetskaya-2020/table-3.1-laval", {"sigma": SIGMA / K})
    first, second = run(Response((0.02, 3.0)), machine), run(Response((0.02 * K, 3.0 * K)), laval())
    assert first.speed.values == pytest.approx(second.speed.values / K, rel=1e-11)
    assert first.amplitude.values == pytest.approx(second.amplitude.values / E, rel=1e-10)
    assert first.centre_distance.values == pytest.approx(second.centre_distance.values / E, rel=1e-10)
    assert first.vibration_torque.values == pytest.approx(second.vibration_torque.values / (M * E**2 * K**2), rel=1e-9)


def test_the_self_balancing_rotor_is_its_real_machine() -> None:
    """Table 5.1 against R1 with the same phases: xi = x M*/(m r); its printed eccentricity is e M*/(m r) = 1/w."""
    phases = {"psi": 2.0, "delta": 0.6}
    first = run(Response((0.02, 3.0), bodies="held", start=phases), load_machine("drozdetskaya-2020/table-5.1"))
    second = run(Response((2.0, 300.0), bodies="held", start=phases), load_machine("drozdetskaya-2020/r1"))
    unit = 0.125 * 0.104 / 10.0
    w = load_machine("drozdetskaya-2020/table-5.1").values["w"]
    assert float(first.eccentricity) == pytest.approx(1 / w)
    assert first.amplitude.values == pytest.approx(second.amplitude.values / unit, rel=1e-3)  # s, w are printed with few digits
    assert first.centre_distance.values == pytest.approx(second.centre_distance.values / unit, rel=1e-3)


# --- against the full equations ---

PAIR = [
    ROTOR | {"position": [0.3, 0.1], "bearing_damping": 0.002},
    ROTOR | {"name": "second", "position": [-0.2, 0.15], "eccentricity": 2e-3},
]
CASES: dict[str, tuple[dict[str, Any], float, dict[str, Any]]] = {
    "two stiffnesses, between the critical speeds": (
        {"carrier": {"stiffness": [1e5, 3e5], "damping": [400.0, 300.0]}, "bodies": [ROTOR]}, 130.0, {},
    ),
    "two stiffnesses, clockwise": (
        {"carrier": {"stiffness": [1e5, 3e5], "damping": [400.0, 300.0]}, "bodies": [ROTOR]}, -170.0, {},
    ),
    "two exciters on a rigid body": (
        {
            "carrier": {
                "directions": "xyr", "mass": 50.0, "inertia": 4.0,
                "mounts": [
                    {"at": [-0.5, -0.1], "stiffness": [2e5, 4e5], "damping": [2e3, 2e3]},
                    {"at": [0.4, -0.2], "stiffness": [2e5, 5e5], "damping": [2e3, 3e3]},
                ],
            },
            "bodies": PAIR,
        }, 110.0, {},
    ),
    "a foundation": (
        {
            "carrier": {
                "stiffness": 1e5, "damping": 300.0,
                "foundation": {"direction": "y", "mass": 20.0, "stiffness": 3e5, "damping": 900.0},
            },
            "bodies": [ROTOR],
        }, 95.0, {},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_settled_run_at_constant_speed(name: str) -> None:
    described, speed, start = CASES[name]
    drives = [{"on": "drum", "kind": "constant-speed", "speed": speed, "angle": 0.4}]
    if any(b["name"] == "second" for b in described["bodies"]):
        drives.append({"on": "second", "kind": "constant-speed", "speed": -speed, "angle": 1.1})
    machine = machine_from(described | {"drives": drives})
    flow, w, per_turn = compile_system(machine.system), abs(speed), 64
    settled = math.ceil(3.0 * w / (2 * math.pi))  # whole turns in 3 s: the start has decayed to exp(-24) or less
    time = np.concatenate([[0.0], (settled + np.arange(per_turn) / per_turn) * 2 * math.pi / w])
    settling = integrate(flow, initial_state(machine, start), machine.values, time)
    row = dict(zip(machine.system.state_names, settling.states[:, 1:], strict=True))
    outputs = flow.outputs(settling.time, settling.states, settling.final_parameter_values)

    response = run(Response((0.9 * w, 1.1 * w), points=3, start=start), machine).sel(speed=w)
    turned = w * settling.time[1:]
    displacement = response.displacement_real.values + 1j * response.displacement_imag.values
    shape = (displacement[:, None] * np.exp(1j * turned)).real
    for k, c in enumerate(machine.carrier):
        vibrating = row[c.position.name] - row[c.position.name].mean()  # bearings load the carrier with a constant moment
        assert vibrating == pytest.approx(shape[k], abs=1e-8 * np.abs(shape[k]).max())
    # The orbit of the axis: its largest and smallest distance, and the sense in which it is run through.
    x, y = outputs["orbit.x"][1:], outputs["orbit.y"][1:]
    moved = np.fft.fft(x + 1j * y) / per_turn
    sense = 1 if speed > 0 else -1
    forward, backward = abs(moved[sense]), abs(moved[-sense])
    assert float(response.amplitude) == pytest.approx(forward + backward, rel=1e-8)
    assert float(response.minor_axis) == pytest.approx(forward - backward, rel=1e-7)
    if math.isfinite(float(response.centre_distance)):
        turn = np.linspace(0, 2 * math.pi, 20_001)
        centre = moved[1] * np.exp(1j * turn) + moved[-1] * np.exp(-1j * turn) + E * np.exp(1j * (0.4 + sense * turn))
        assert float(response.centre_distance) == pytest.approx(np.abs(centre).max(), rel=1e-6)
    # The torque: the mean power of all drives over a turn.
    assert float(response.required_torque) == pytest.approx(outputs["motor_power"][1:].mean() / w, rel=1e-6)


# --- working points: 3.2 ---


def balance(u: float, name: str = "carrier") -> list[dict[str, Any]]:
    machine = load_machine(f"drozdetskaya-2020/table-3.1-{name}", {"u": u})
    return list(run(TorqueBalance(), machine).wucht.summary["working_points"])


def test_three_working_points() -> None:
    """cases.md, table 3.1 at u = 2: seven decimals, so 1e-7."""
    points = balance(2.0)
    assert [p["speed"] for p in points] == pytest.approx([0.9686444, 1.0937039, 1.8176384], abs=1e-7)
    assert [p["stable"] for p in points] == [True, False, True]
    for p in points:  # (3.51)
        w = p["speed"]
        assert 2 * (2 - w) == pytest.approx(0.1 * w**5 / ((1 - w**2) ** 2 + 0.04 * w**2), rel=1e-12)
        assert p["torque"] == pytest.approx(2 * (2 - w), rel=1e-14)
        assert (p["slope"], p["no_load_speed"]) == pytest.approx((2.0, 2.0), rel=1e-14)


def test_the_laval_rotor_has_them_at_twice_the_slope() -> None:
    """(3.67): the fold values of u double."""
    assert [p["speed"] for p in balance(4.0, "laval")] == pytest.approx([p["speed"] for p in balance(2.0)], rel=1e-12)


@pytest.mark.parametrize(("u", "omega"), [(2.6053860, 1.0213376), (0.8937191, 1.4239669)])
def test_folds(u: float, omega: float) -> None:
    """cases.md: there two of the points meet; within 1e-6 of u there are three on one side, and one on the other."""
    counts = {len(balance(u * (1 + d))) for d in (-1e-6, 1e-6)}
    assert counts == {1, 3}
    near = sorted(abs(p["speed"] - omega) for p in balance(u * (1 + (1e-6 if u < 1 else -1e-6))))
    assert near[1] < 2e-3  # the two leave the fold as the square root
    assert near[0] < 2e-3
