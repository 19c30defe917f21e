"""Switchable pendulums against masses at absolute positions, and against two bodies written by hand with their stops."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.refusals import refused

from witness import energy_gap, moved
from wucht import Machine, RunUp, parts, run
from wucht.files.building import machine_from

CARRIER = {"mass": 1.0, "stiffness": [4e3, 9e3], "damping": [6.0, 9.0], "gravity": 9.81}
DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.03}
DRIVE = {"kind": "linear", "on": "drum", "slope": 0.05, "no_load_speed": 45.0}
PENDULUM = {
    "kind": "switchable-pendulum", "name": "p", "about": "drum", "mass": 0.3, "damping": 0.02, "moving_mass": 0.2,
    "inner_stop": 0.05, "outer_stop": 0.09, "stiffness": 300.0, "preload": 20.0,
}  # fmt: skip
FIXED = {"directions": "fixed"}


def test_through_opening_and_impacts_it_moves_as_two_bodies_written_by_hand() -> None:
    """A drum at a steady speed on a fixed axis: J(s) theta'' + 2 m r s' theta' = b (w - theta') and m s'' = m r theta'^2 - F.

    At 46 rad/s it opens (at 44.7), hits the outer stop, is then so slow that it closes, and opens again as it speeds up.
    """
    drive = {"kind": "constant-speed", "on": "drum", "speed": 46.0}
    document = {"carrier": FIXED, "bodies": [DRUM, PENDULUM | {"inertia": 0.004}], "drive": drive}
    grid = np.linspace(0.0, 0.5, 501)
    rows = moved(document, {}, grid)
    b, m, r, out, c, force, e, j = 0.02, 0.2, 0.05, 0.04, 300.0, 20.0, 0.5, 0.004
    omega = 50 * math.sqrt(force / (m * r))
    zeta = -math.log(e) / math.hypot(math.pi, math.log(e))

    def rates(_t: float, q: np.ndarray) -> list[float]:
        _, w, s, v = q
        push = 0.0
        for gap, way in ((s, 1.0), (out - s, -1.0)):
            push -= way * m * (omega**2 * gap + 2 * zeta * omega * way * v) if gap < 0 else 0.0
        radius = r + s
        return [
            w,
            (b * (46.0 - w) - 2 * m * radius * v * w) / (j + m * radius**2),
            v,
            radius * w**2 - (force + c * s - push) / m,
        ]

    theirs = solve_ivp(rates, (0, 0.5), [0, 46.0, 0, 0], "DOP853", grid, rtol=1e-10, atol=1e-12, max_step=1e-4).y
    assert rows["p.displacement"] == pytest.approx(theirs[2], abs=1e-6)
    assert rows["p.speed"] == pytest.approx(theirs[1], rel=1e-5)
    s = rows["p.displacement"]
    assert s.max() > 0.04
    assert np.count_nonzero(np.diff(np.sign(s - 0.02))) == 3, "it opens, closes, and opens again"
    assert energy_gap(rows) < 1e-10


@pytest.mark.parametrize("restitution", [0.1, 0.5, 1.0])
def test_an_impact_returns_with_the_restitution_and_books_what_it_loses(restitution: float) -> None:
    """Nothing turns; the mass flies against the outer stop at 2 m/s, the spring being almost without force."""
    soft = PENDULUM | {"preload": 1e-9, "stiffness": 0.0, "restitution": restitution, "contact_frequency": 5e3}
    document = {"carrier": FIXED, "bodies": [DRUM, soft]}
    rows = moved(document, {"p": {"displacement": 0.01, "velocity": 2.0}}, np.linspace(0.0, 0.0175, 36))
    assert rows["p.velocity"][-1] == pytest.approx(-2.0 * restitution, rel=1e-6)
    lost = 0.2 * 2.0**2 / 2 * (1 - restitution**2)
    assert rows["dissipated_work"][-1] == pytest.approx(lost, rel=1e-6, abs=1e-9)
    assert rows["stored_energy"][0] - rows["stored_energy"][-1] == pytest.approx(lost, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("key", "value", "code", "names"),
    [("outer_stop", 0.05, "", ["inner stop", "0.05 m"]), ("inertia", 1e-4, "", ["0.000333333"])],
)
def test_what_no_pendulum_can_have_is_refused(key: str, value: float, code: str, names: list[str]) -> None:
    with refused(f"machine.bodies[1] (p).{key}", *names, given=value, code=code):
        machine_from({"carrier": CARRIER, "bodies": [DRUM, PENDULUM | {key: value}], "drive": DRIVE})


def rotor_with(preload: str, **more: str) -> Machine:
    """The rotor of drozdetskaya-2020/switchable-pendulums, with pendulums whose preload may be too much."""
    frame = {"mass": "0.5 kg", "inertia": "0.01 kg m^2", "damping": "0.05 N m s", "moving_mass": "0.25 kg"} | more
    stops = {"inner_stop": "52 mm", "outer_stop": "104 mm", "stiffness": "1500 N/m", "preload": preload}
    bodies = [parts.SwitchablePendulum(name=n, about="drum", **frame, **stops) for n in ("p1", "p2")]
    drum = parts.Rotor(name="drum", mass="8.5 kg", unbalance="9.75e-3 kg m", inertia="0.0338 kg m^2")
    motor = parts.LinearDrive(slope="0.078 N m s", no_load_speed="200 rad/s")
    return Machine(parts.Carrier(stiffness="1e5 N/m", damping="200 N s/m"), [drum, *bodies], [motor])


@pytest.mark.slow
def test_pendulums_that_stand_where_they_would_compensate_but_stay_closed_compensate_nothing() -> None:
    """cos(angle) = -U/(2 m_s d): 112.02 degrees. What is left of the unbalance is that of the drum, and the verdict says so."""
    at = math.acos(-9.75e-3 / (2 * 0.25 * 0.052))
    start = {"drum": {"speed": "199.9 rad/s"}} | {
        n: {"angle": s * at, "speed": "199.9 rad/s"} for n, s in (("p1", 1), ("p2", -1))
    }
    closed, opened = (
        run(RunUp(until="8 s", start=start), rotor_with(preload)).wucht.summary for preload in ("1000 N", "292.5 N")
    )
    assert (closed["outcome"], opened["outcome"]) == ("passed", "compensated")
    assert closed["final_residual_unbalance"] == pytest.approx(1.0, abs=2e-3)
    assert opened["final_residual_unbalance"] < 1e-3
    assert closed["energy_residual"] < 1e-10
    assert opened["energy_residual"] < 1e-10


@pytest.mark.parametrize("permanent", [0.0, 2e-3, -2e-3])
def test_a_frame_that_does_not_balance_its_mass_is_doubted(permanent):
    """0.2 kg at 50 mm is balanced by 0.3 kg at 33.3 mm; a permanent unbalance is meant, the rest is not."""
    table = {k: v for k, v in PENDULUM.items() if k != "kind"} | {"permanent_unbalance": permanent}
    for length, residual in ((None, None), (0.1 / 3, None), (0.03, "0.001 kg m"), (0.04, "-0.002 kg m")):
        doubts = parts.SwitchablePendulum(**table, **({} if length is None else {"length": length})).doubts()
        if residual is None:
            assert doubts == ()
        else:
            assert f"an unbalance of {residual} while" in doubts[0] and "with length = 0.0333333 m" in doubts[0]
