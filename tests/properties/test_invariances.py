"""What must hold for every machine: energy balances, and nothing depends on names, directions or units; witnesses agree.

Machines are drawn at random: a rotor with up to three pendulums or rollers on a carrier, all within what could be built.
"""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from tests.reference_integrators import needs_heyoka, taylor_states

from wucht import RunUp, run
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.machines.machine import DISSIPATED_WORK, SUPPLIED_WORK
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

TURN = 2 * math.pi
few = settings(
    max_examples=10, deadline=None, suppress_health_check=list(HealthCheck),
    phases=(Phase.explicit, Phase.generate),  # a failing machine is shown as drawn: to simplify it takes minutes of compiling
)  # fmt: skip


def numbers(low, high):
    """A thousand values between two limits, both included: nothing is learnt from the last bits."""
    return st.integers(0, 1000).map(lambda i: low + (high - low) * i / 1000)


@st.composite
def pendulums(draw):
    mass, length = draw(numbers(0.02, 0.3)), draw(numbers(0.03, 0.15))
    inertia = mass * length**2 * draw(numbers(1.0, 2.0))
    return {"kind": "pendulum", "mass": mass, "length": length, "inertia": inertia, "damping": draw(numbers(0.0, 0.1))}


@st.composite
def rollers(draw):
    track = draw(numbers(0.05, 0.15))
    return {
        "kind": "roller", "mass": draw(numbers(0.02, 0.3)), "track_radius": track, "radius": track * draw(numbers(0.05, 0.5)),
        "shape_factor": draw(st.sampled_from([0.4, 0.5])), "damping": draw(numbers(0.0, 0.05)),
    }  # fmt: skip


BALANCERS = {"P": pendulums(), "R": rollers()}
STRUCTURES = ("", "P", "PP", "PR", "PRR")  # few, because each compiles; values are what varies


@st.composite
def machines(draw, structures=STRUCTURES, isotropic=None, gravity=None):
    """A table [machine] in SI floats. Natural frequencies of some 50 to 150 rad/s, the motor faster or slower than that."""
    chosen = [draw(BALANCERS[kind]) for kind in draw(st.sampled_from(structures))]
    mass, e = draw(numbers(1.0, 10.0)), draw(numbers(2e-4, 3e-3))
    total = mass + sum(b["mass"] for b in chosen)
    k, sigma = draw(numbers(50.0, 150.0)), draw(numbers(0.01, 0.3))
    stiffness, damping = total * k**2, 2 * total * k * sigma
    if not (draw(st.booleans()) if isotropic is None else isotropic):
        stiffness, damping = [stiffness, stiffness * draw(numbers(0.3, 3.0))], [damping, damping * draw(numbers(0.3, 3.0))]
    inertia = mass * (e**2 + draw(numbers(0.02, 0.15)) ** 2 / 2)
    moved = inertia + sum(b["mass"] * 0.15**2 for b in chosen)
    return {
        "carrier": {
            "stiffness": stiffness,
            "damping": damping,
            "gravity": draw(st.sampled_from([0.0, 9.81])) if gravity is None else gravity,
        },
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": mass, "eccentricity": e, "inertia": inertia,
             "bearing_damping": draw(st.sampled_from([0.0, 1e-3]))},
            *(b | {"name": f"b{i}", "about": "drum"} for i, b in enumerate(chosen)),
        ],
        "drive": {
            "kind": "linear", "slope": moved * k / draw(numbers(5.0, 50.0)), "no_load_speed": k * draw(numbers(0.5, 3.0)),
        },
    }  # fmt: skip


angles = st.lists(numbers(-3.0, 3.0), min_size=4, max_size=4)


def start_of(document, given_angles):
    return {b["name"]: a for b, a in zip(document["bodies"], given_angles, strict=False)}


def twenty_turns(document):
    """The time of twenty turns at the no-load speed."""
    return 20 * TURN / abs(document["drive"]["no_load_speed"])


def motion(document, start, until, samples=201, **options):
    """Every state, output and work over time, by name; the machine must not have failed."""
    machine = machine_from(document)
    flow = compile_system(machine.system, **options)
    time = np.linspace(0, until, samples)
    run = integrate(flow, initial_state(machine, start), machine.values, time)
    assert run.failure is None
    actual = dict(zip(machine.system.state_names, run.states, strict=True)) | dict(run.quadratures)
    return actual | flow.outputs(run.time, run.states, run.final_parameter_values)


def assert_equal(one, other, tolerance):
    """Two signals agree, measured by the largest value of the first."""
    assert np.abs(one - other).max() <= tolerance * max(np.abs(one).max(), 1e-300)


@few
@given(machines(), angles)
def test_energy_is_booked_completely(document, start):
    """Work of the motor less what the dampers take is what is stored: full equations, outputs and quadratures together."""
    run = motion(document, start_of(document, start), twenty_turns(document))
    gap = run[SUPPLIED_WORK] - run[DISSIPATED_WORK] - (run["stored_energy"] - run["stored_energy"][0])
    scale = max(np.abs(run[SUPPLIED_WORK]).max(), np.abs(run["stored_energy"]).max())
    assert np.abs(gap).max() / scale < 1e-9
    assert (np.diff(run[DISSIPATED_WORK]) >= 0).all()  # dampers only take


@few
@given(machines(("P", "PR")), angles)
def test_a_run_up_reports_its_energy_residual(document, start):
    machine = machine_from(document)
    result = run(RunUp(until=twenty_turns(document), start=start_of(document, start)), machine)
    assert result.wucht.summary["energy_residual"] < 1e-9


@needs_heyoka
@few
@given(machines(("", "PP", "PR")), angles)
def test_the_motion_is_that_of_a_witness(document, start):
    """Over five turns, of machines that may amplify errors of a step a thousandfold: with 1e-12 one was off by 1.7e-9."""
    machine, begin, until = machine_from(document), start_of(document, start), twenty_turns(document) / 4
    system = machine.system
    witness = taylor_states(system, initial_state(machine, begin), machine.values, np.linspace(0, until, 51))
    run = motion(document, begin, until, samples=51, tolerance=1e-13)
    for name, signal in zip(system.state_names, witness, strict=True):
        assert_equal(signal, run[name], 1e-9)


@few
@given(machines(("PP", "PR")), angles)
def test_the_order_of_bodies_in_the_file_does_not_matter(document, start):
    drum, *others = document["bodies"]
    begin, until = start_of(document, start), twenty_turns(document)
    one, other = motion(document, begin, until), motion(document | {"bodies": [*others[::-1], drum]}, begin, until)
    for name, signal in one.items():
        assert_equal(signal, other[name], 1e-8)


@few
@given(machines(("P",), isotropic=False), st.permutations([0, 1, 2]), angles)
def test_equal_pendulums_may_change_places(document, order, start):
    """Each of three equal pendulums does what the one with its start angle did; the others do not notice."""
    drum, one = document["bodies"]
    three, until = document | {"bodies": [drum, *(one | {"name": f"p{i}"} for i in range(3))]}, twenty_turns(document)
    reference = motion(three, {f"p{i}": a for i, a in enumerate(start[:3])}, until)
    swapped = motion(three, {f"p{i}": start[k] for i, k in enumerate(order)}, until)
    for i, k in enumerate(order):
        assert_equal(reference[f"p{k}.angle"], swapped[f"p{i}.angle"], 1e-8)
        assert_equal(reference[f"p{k}.speed"], swapped[f"p{i}.speed"], 1e-8)
    for name in ("carrier.x", "carrier.y", "drum.speed", "stored_energy", "motor_power"):
        assert_equal(reference[name], swapped[name], 1e-8)


@few
@given(machines(isotropic=True, gravity=0.0), angles, numbers(-3.1, 3.1))
def test_a_turned_frame_turns_the_orbit_and_nothing_else(document, start, turn):
    begin, until = start_of(document, start), twenty_turns(document)
    turned = begin | {"drum": begin["drum"] + turn}
    carrier = np.array([2e-3, -1e-3])
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    one = motion(document, begin | {"carrier": dict(zip("xy", carrier.tolist(), strict=True))}, until)
    other = motion(document, turned | {"carrier": dict(zip("xy", (rotation @ carrier).tolist(), strict=True))}, until)
    for a, b in (("carrier.x", "carrier.y"), ("carrier.vx", "carrier.vy"), ("bearing_force_x", "bearing_force_y")):
        there = rotation @ np.array([one[a], one[b]])
        assert_equal(there, np.array([other[a], other[b]]), 1e-8)
    for body in document["bodies"]:
        assert_equal(one[f"{body['name']}.speed"], other[f"{body['name']}.speed"], 1e-8)
        assert np.abs(other[f"{body['name']}.angle"] - one[f"{body['name']}.angle"] - turn).max() < 1e-7
    for name in ("stored_energy", "motor_torque", SUPPLIED_WORK, DISSIPATED_WORK):
        assert_equal(one[name], other[name], 1e-8)


@few
@given(machines(gravity=0.0), angles)
def test_the_mirror_image_that_turns_the_other_way(document, start):
    """Mirrored at the x-axis: angles, torques and y change sign, all else stays."""
    mirrored = document | {"drive": document["drive"] | {"no_load_speed": -document["drive"]["no_load_speed"]}}
    begin, until = start_of(document, start), twenty_turns(document)
    one, other = motion(document, begin, until), motion(mirrored, {n: -a for n, a in begin.items()}, until)
    for name, signal in one.items():
        odd = name.endswith((".angle", ".speed", "torque", ".y", ".vy", "_y"))
        assert_equal(signal, -other[name] if odd else other[name], 1e-8)


@few
@given(machines(gravity=9.81), angles)
def test_the_mirror_image_under_gravity(document, start):
    """Mirrored at the vertical: an angle a becomes pi - a, x changes sign, and what falls still falls."""
    mirrored = document | {"drive": document["drive"] | {"no_load_speed": -document["drive"]["no_load_speed"]}}
    begin, until = start_of(document, start), twenty_turns(document)
    other_start = {n: -a for n, a in begin.items()} | {"drum": math.pi - begin["drum"]}
    one, other = motion(document, begin, until), motion(mirrored, other_start, until)
    for name, signal in one.items():
        if name.endswith(".angle"):
            assert_equal(signal, math.pi - other[name], 1e-8)
        else:
            odd = name.endswith((".speed", "torque", ".x", ".vx", "_x"))
            assert_equal(signal, -other[name] if odd else other[name], 1e-8)


UNITS = {  # by key of the file: a unit of the workshop, and how many of it are one SI unit
    "mass": ("g", 1e3), "eccentricity": ("um", 1e6), "length": ("mm", 1e3), "track_radius": ("cm", 1e2), "radius": ("mm", 1e3),
    "inertia": ("kg cm^2", 1e4), "damping": ("N mm s", 1e3), "bearing_damping": ("mN m s", 1e3),
    "slope": ("N m / rpm", TURN / 60), "no_load_speed": ("rpm", 60 / TURN),
}  # fmt: skip
CARRIER_UNITS = {"stiffness": ("N/mm", 1e-3), "damping": ("kN s/m", 1e-3), "gravity": ("cm/s^2", 1e2)}


def in_units(table, units):
    def say(key, value):
        if isinstance(value, list):
            return [say(key, v) for v in value]
        return f"{value * units[key][1]!r} {units[key][0]}" if key in units else value

    return {key: say(key, value) for key, value in table.items()}


@few
@given(machines(("P", "PR")), angles)
def test_the_units_of_the_file_do_not_matter(document, start):
    completed = {
        "carrier": in_units(document["carrier"], CARRIER_UNITS),
        "bodies": [in_units(b, UNITS) for b in document["bodies"]],
        "drive": in_units(document["drive"], UNITS),
    }
    si, workshop = machine_from(document), machine_from(completed)
    assert workshop.values == pytest.approx(si.values, rel=1e-14)
    assert workshop.system == si.system
    begin, until = start_of(document, start), twenty_turns(document)
    asked = {"until": f"{until * 1e3!r} ms", "start": {n: f"{math.degrees(a)!r} deg" for n, a in begin.items()}}
    one, other = run(RunUp(until=until, start=begin), si), run(RunUp.from_table(asked), workshop)
    assert other.attrs["outcome"] == one.attrs["outcome"]
    for name in ("speed", "displacement", "motor_torque", "bearing_force", "residual_unbalance"):
        assert_equal(one[name].values[..., -1], other[name].values[..., -1], 1e-8)


@few
@given(machines(), angles, numbers(0.2, 5.0), numbers(0.2, 5.0), numbers(0.2, 5.0))
def test_a_machine_scaled_in_mass_length_and_time_is_the_same_machine(document, start, mass, length, time):
    """Dimensional analysis as a test of every formula: a term of the wrong dimension would not scale with the others."""
    dimension = {
        "mass": mass, "eccentricity": length, "length": length, "track_radius": length, "radius": length,
        "inertia": mass * length**2, "damping": mass * length**2 / time, "bearing_damping": mass * length**2 / time,
        "slope": mass * length**2 / time, "no_load_speed": 1 / time,
    }  # fmt: skip
    of_carrier = {"stiffness": mass / time**2, "damping": mass / time, "gravity": length / time**2}

    def scaled(table, factors):
        def value(key, v):
            return [value(key, w) for w in v] if isinstance(v, list) else v * factors[key] if key in factors else v

        return {key: value(key, v) for key, v in table.items()}

    other_document = {
        "carrier": scaled(document["carrier"], of_carrier),
        "bodies": [scaled(b, dimension) for b in document["bodies"]],
        "drive": scaled(document["drive"], dimension),
    }
    begin, until = start_of(document, start), twenty_turns(document)
    one, other = motion(document, begin, until), motion(other_document, begin, until * time)
    energy, force = mass * length**2 / time**2, mass * length / time**2
    for name, signal in one.items():
        factor = (
            1.0 if name.endswith(".angle")
            else 1 / time if name.endswith(".speed")
            else length if name in ("carrier.x", "carrier.y", "orbit.x", "orbit.y")
            else length / time if name in ("carrier.vx", "carrier.vy", "orbit.vx", "orbit.vy")
            else force if name.startswith("bearing_force")
            else energy / time if name == "motor_power"
            else energy
        )  # fmt: skip
        assert_equal(signal * factor, other[name], 1e-7)


@few
@given(machines(("", "P"), gravity=0.0), angles)
def test_an_unbalance_is_mass_times_eccentricity(document, start):
    drum, *others = document["bodies"]
    direct = {k: v for k, v in drum.items() if k != "eccentricity"} | {"unbalance": drum["mass"] * drum["eccentricity"]}
    begin, until = start_of(document, start), twenty_turns(document)
    one, other = motion(document, begin, until), motion(document | {"bodies": [direct, *others]}, begin, until)
    for name, signal in one.items():
        assert_equal(signal, other[name], 1e-8)


@few
@given(machines(("PP",), gravity=0.0), angles)
def test_what_is_balanced_does_not_shake(document, start):
    """A rotor without unbalance and two equal pendulums opposite to each other: the carrier stays where it is."""
    drum, one, _ = document["bodies"]
    drum = drum | {"eccentricity": 0.0}
    balanced = document | {"bodies": [drum, one | {"name": "a"}, one | {"name": "b"}]}
    run = motion(balanced, {"drum": start[0], "a": start[1], "b": start[1] + math.pi}, twenty_turns(document) / 4)
    assert np.hypot(run["carrier.x"], run["carrier.y"]).max() < 1e-10
    assert_equal(run["b.angle"] - math.pi, run["a.angle"], 1e-8)
