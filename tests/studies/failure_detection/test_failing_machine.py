"""The stiffness falls while the machine runs: energy, work and damage against ways of their own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import simpson

import wucht

START = {"p1": 0.3, "p2": -0.5}
SENSOR = {"interval": 0.1, "noise": 1.0, "false_alarm_every": 3600.0}
WHOLE, LEFT, UNTIL = 1e5, 8e4, 8.0
LINE = {"k": 5, "ND": 100, "SD": "8 mm"}


def exciter(*points, interpolation="steps"):
    """R1 with unequal pendulums; points of a schedule of its stiffness."""
    p = wucht.parts
    pendulums = [
        p.Pendulum(name=name, about="drum", mass=mass, length=0.104, inertia=1.69e-3, damping=0.169)
        for name, mass in (("p1", 0.125), ("p2", 0.126))
    ]
    drum = p.Rotor(name="drum", mass=9.75, eccentricity=1e-3, inertia=9.75e-4)
    schedule = {"parameter": "carrier.stiffness", "points": list(points), "interpolation": interpolation}
    return wucht.Machine(
        p.Carrier(stiffness=WHOLE, damping=200.0),
        [drum, *pendulums],
        [p.LinearDrive(slope=0.01365, no_load_speed=200.0)],
        schedules=[schedule] if points else [],
    )


def failed(machine, **keys):
    keys = {"until": UNTIL, "start": START, "sensor": SENSOR, "after": 0.5} | keys
    return wucht.run(wucht.FailureDetection(**keys), machine)


def moved(machine, until=UNTIL):
    """Time, angle of the rotor and x^2 + y^2 of a run-up of its own, and the stiffness over time."""
    run = wucht.run(wucht.RunUp(until=until, start=START), machine)
    return run.time.values, run.angle.values[0], (run.displacement.values**2).sum(axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("interpolation", ["linear", "smooth", "steps"])
def test_the_work_of_a_schedule_is_that_of_the_spring(interpolation):
    """c'(t) (x^2 + y^2)/2 over time, or (c2 - c1)(x^2 + y^2)/2 at a jump; and the energy closes over all of it."""
    begin, end = 4.0, 4.5
    points = [(0.0, WHOLE), (begin, LEFT)] if interpolation == "steps" else [(begin, WHOLE), (end, LEFT)]
    machine = exciter(*points, interpolation=interpolation)
    result = failed(machine)
    time, angle, square = moved(machine)
    if interpolation == "steps":
        work = (LEFT - WHOLE) / 2 * np.interp(begin, time, square)
        tolerance = 0.02  # of a displacement between samples
    else:
        inside = (time >= begin) & (time <= end)
        share = (time[inside] - begin) / (end - begin)
        slope = 6 * share * (1 - share) if interpolation == "smooth" else np.ones(len(share))
        work = simpson((LEFT - WHOLE) / (end - begin) * slope * square[inside] / 2, x=time[inside])
        tolerance = 0.01  # of the samples at both ends
    assert result["energy_residual"].values.max() < 1e-9
    assert result["stiffness_work"].values[-1] == pytest.approx(work, rel=tolerance)
    assert work < -0.1
    at = result["time"].values
    assert result["speed"].values.sum() * SENSOR["interval"] == pytest.approx(angle[-1], rel=1e-6)
    shares = [float(result["stiffness"].values[at < begin - 0.01].min()), float(result["stiffness"].values[-1])]
    assert shares == pytest.approx([1.0, LEFT / WHOLE])
    assert result.wucht.summary["failure_time"] == begin


@pytest.mark.slow
@pytest.mark.parametrize("law", ["drop", "linear"])
def test_a_failure_by_damage_is_one_by_a_schedule_of_the_same_steps(law):
    """The same motion, work and energy; and the damage is that of the whole history counted at once."""
    own = {"remaining": 0.8, "law": law, "direction": "x", "woehler": LINE}
    more = {"learning": 1.5} if law == "linear" else {}
    result = failed(exciter(), failure=own, **more)
    time, share = result["time"].values, result["stiffness"].values
    # A look at the end of a sample changes what comes after it.
    changes = np.flatnonzero(np.diff(share)) + 1
    steps = [(0.0, WHOLE), *((float(time[i - 1]), float(WHOLE * share[i])) for i in changes)]
    again = exciter(*steps)
    assert len(changes) == 1 if law == "drop" else len(changes) > 20
    at, angle, square = moved(again)
    assert result["speed"].values.cumsum() * SENSOR["interval"] == pytest.approx(
        np.interp(result["reading_time"].values, at, angle), abs=2e-3
    )
    assert result["speed"].values.sum() * SENSOR["interval"] == pytest.approx(angle[-1], rel=1e-9)
    jumps = np.diff([k for _, k in steps]) / 2 * np.interp([t for t, _ in steps[1:]], at, square)
    assert result["stiffness_work"].values[-1] == pytest.approx(jumps.sum(), rel=0.02)
    assert result["energy_residual"].values.max() < 1e-9
    spectrum = wucht.run(wucht.LoadSpectrum(until=UNTIL, start=START, direction="x", woehler=LINE), again)
    assert result.wucht.summary["damage"] == pytest.approx(spectrum.wucht.summary["damage"], rel=1e-5)
    s, damage = result.wucht.summary, result["damage"].values
    assert s["failure_time"] == pytest.approx(time[np.flatnonzero(damage >= 1.0)[0]], abs=0.1)
    # Each look comes after eight samples: nothing until D = 1, or the share D of the loss.
    seen, then = damage[8:-1:8], share[9::8]
    lost = (seen >= 1.0).astype(float) if law == "drop" else np.minimum(seen, 1.0)
    assert then == pytest.approx(1 - 0.2 * lost, rel=1e-9)


def test_the_load_may_be_the_force_of_the_spring():
    """Of a stiffness that is constant, the force is the displacement times that."""
    force_line, times = LINE | {"SD": 8e-3 * WHOLE}, list[float]()
    for name, line in (("displacement", LINE), ("spring-force", force_line)):
        failure = {"remaining": 0.8, "signal": name, "direction": "x", "woehler": line}
        times.append(failed(exciter(), failure=failure, until=5.0).wucht.summary["failure_time"])
    assert times[0] == times[1]
    force, displacement = (
        wucht.run(wucht.LoadSpectrum(until=1.0, start=START, direction="x", signal=name), exciter())
        for name in ("spring-force", "displacement")
    )
    assert force.wucht.summary["largest_range"] == pytest.approx(WHOLE * displacement.wucht.summary["largest_range"])
    assert force.wucht.summary["unit"] == "N"
