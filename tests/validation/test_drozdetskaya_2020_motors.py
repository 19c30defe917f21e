"""The dissertation's motors: their characteristics against the circuits from which it derives them.

Olga Drozdetskaya, "Zur Dynamik eines unwuchtigen Rotors mit Selbstauswuchtsystem" (On the dynamics of an unbalanced
rotor with a self-balancing system), dissertation, Karlsruher Institut fuer Technologie (KIT), Karlsruhe 2020. Source 002,
section 2.2.2; equations are numbered as there, corrected where ``errata.md`` says so.

The circuits are solved as they stand, currents and all, and never by the formulas that follow from them. Tolerances: relative
1e-10, since both sides are closed expressions or small linear systems; where a maximum is sought numerically, or a limit is
approached, the case says so.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

from wucht.machines.parts.dc_separate import DCSeparate
from wucht.machines.parts.dc_series import DCSeries
from wucht.machines.parts.dc_shunt import DCShunt
from wucht.machines.parts.induction import Induction

EXACT = 1e-10  # relative
some = settings(max_examples=50, deadline=None)


def numbers(low, high):
    """A thousand values between two limits, both included."""
    return st.integers(0, 1000).map(lambda i: low + (high - low) * i / 1000)


# DC motors

U, RA, RE, L, K, FLUX = 220.0, 1.8, 0.9, 0.12, 1.4, 0.7
SEPARATE = DCSeparate(on="m", voltage=U, armature_resistance=RA, motor_constant=K, flux=FLUX)
SHUNT = DCShunt(on="m", voltage=U, armature_resistance=RA, field_resistance=150 * RE, field_inductance=L, motor_constant=K)
SERIES = DCSeries(on="m", voltage=U, armature_resistance=RA, field_resistance=RE, field_inductance=L, motor_constant=K)


def armature(voltage, flux, speed):
    """Current and induced voltage: U - U_i = R_A I, (2.88), and U_i = k Phi w, (2.90), as two linear equations."""
    return np.linalg.solve([[RA, 1.0], [0.0, 1.0]], [voltage, K * flux * speed])


@some
@given(voltage=numbers(-400, 400), speed=numbers(-500, 500))
def test_the_separately_excited_motor_against_its_circuit(voltage, speed):
    """T = k I Phi, (2.85), is (2.92); and what the source gives is lost in the armature or leaves by the shaft."""
    current, _ = armature(voltage, FLUX, speed)
    torque = SEPARATE.model_copy(update={"voltage": voltage}).torque_at(speed)
    assert torque == pytest.approx(K * current * FLUX, rel=EXACT, abs=1e-9)
    assert voltage * current == pytest.approx(RA * current**2 + torque * speed, rel=EXACT, abs=1e-6)


@pytest.mark.parametrize("speed", [-100.0, 0.0, 100.0, 224.0])
def test_the_separately_excited_motor_is_the_line_of_the_dissertation(speed):
    """(2.93): slope k^2 Phi^2/R_A and no-load speed U/(k Phi), from any working point."""
    assert SEPARATE.linearisation(speed) == pytest.approx((K**2 * FLUX**2 / RA, U / (K * FLUX)), rel=EXACT)


@some
@given(speed=numbers(-500, 2000))
def test_the_shunt_motor_against_its_circuit(speed):
    """The same source feeds the field: I_E = U/R_E, (2.96), Phi = L I_E, (2.87); it follows (2.99)."""
    field = U / SHUNT.field_resistance
    current, induced = armature(U, L * field, speed)
    torque = SHUNT.torque_at(speed)
    assert torque == pytest.approx(K * current * L * field, rel=EXACT, abs=1e-9)
    assert torque * speed == pytest.approx(induced * current, rel=EXACT, abs=1e-9)  # (2.86)


def test_the_shunt_motor_runs_idle_at_a_speed_that_does_not_depend_on_the_voltage():
    """(2.99): R_E/(k L_E)."""
    for voltage in (110.0, 220.0):
        motor = SHUNT.model_copy(update={"voltage": voltage})
        assert motor.linearisation(50.0)[1] == pytest.approx(SHUNT.field_resistance / (K * L), rel=EXACT)


@some
@given(speed=numbers(-10, 3000))
def test_the_series_motor_against_its_circuit(speed):
    """One current makes field and torque: U - k I L w = (R_A + R_E) I, (2.102), solved by bisection; T = k I^2 L, (2.101)."""
    current = brentq(lambda i: U - K * i * L * speed - (RA + RE) * i, 0.0, 1e4, xtol=1e-14, rtol=1e-15)
    torque = SERIES.torque_at(speed)
    assert torque == pytest.approx(K * current**2 * L, rel=EXACT)
    assert U * current == pytest.approx((RA + RE) * current**2 + torque * speed, rel=EXACT)


def test_the_series_motor_without_load_runs_away():
    """(2.105): w = U/sqrt(k L T) - R/(k L), which inverts (2.104), grows without bound as the torque goes to zero."""
    torques = 10.0 ** np.arange(2, -13, -2)
    speeds = U / np.sqrt(K * L * torques) - (RA + RE) / (K * L)
    assert [SERIES.torque_at(w) for w in speeds] == pytest.approx(torques, rel=1e-9)
    assert speeds[-1] > 1e8
    for speed in speeds:
        slope, no_load = SERIES.linearisation(float(speed))
        assert slope > 0
        assert no_load > speed  # each tangent promises an end that the curve does not have


# Induction motor


def motor(**changes):
    values = {
        "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2.0, "stator_resistance": 0.6, "rotor_resistance": 0.45,
        "stator_reactance": 1.1, "rotor_reactance": 1.3,
    } | changes  # fmt: skip
    return Induction(on="m", **values)


def circuit_torque(m, slip, main_reactance=None):
    """The torque by the equivalent circuit of figure 2.23, as a complex linear system in I_1, I_2 (towards the rotor), U_h.

    (2.110) with I_2 counted so that (2.112) holds: I_1 = I_2 + I_0 and U_h = j X_h I_0; without a main reactance I_0 = 0.
    Torque: the power in the air gap 3 R_2 I_2^2/s, (2.113), over the speed of the field.
    """
    magnetising = 0.0 if main_reactance is None else 1 / (1j * main_reactance)
    matrix = [
        [1.0, -1.0, -magnetising],
        [m.stator_resistance + 1j * m.stator_reactance, 0.0, 1.0],
        [0.0, -(m.rotor_resistance / slip + 1j * m.rotor_reactance), 1.0],
    ]
    _, rotor, _ = np.linalg.solve(np.array(matrix), np.array([0.0, m.voltage, 0.0]))
    return 3 * m.rotor_resistance / slip * abs(rotor) ** 2 / m.synchronous_speed()


def at_slip(m, slip):
    return m.torque_at(m.synchronous_speed() * (1 - slip))


MOTORS = st.builds(
    motor,
    voltage=numbers(10, 400),
    frequency=numbers(5, 100),
    pole_pairs=st.sampled_from([1.0, 2.0, 3.0]),
    stator_resistance=numbers(0, 5),
    rotor_resistance=numbers(0.05, 5),
    stator_reactance=numbers(0, 5),
    rotor_reactance=numbers(0.1, 5),
    sense=st.sampled_from([1, -1]),
)


@some
@given(m=MOTORS, slip=numbers(-2, 3))
def test_the_induction_motor_against_its_circuit(m, slip):
    """(2.119) as a motor, as a generator (s < 0) and as a brake (s > 1)."""
    assume(abs(slip) > 1e-6)
    assert at_slip(m, slip) == pytest.approx(circuit_torque(m, slip), rel=1e-9)


@some
@given(m=MOTORS, slip=numbers(0.01, 3))
def test_the_induction_motor_as_printed(m, slip):
    """(2.119) itself, with its division by the slip; the mechanical power is (2.115)."""
    X = m.stator_reactance + m.rotor_reactance
    R2, R1, w = m.rotor_resistance, m.stator_resistance, m.synchronous_speed()
    current = m.voltage / math.hypot(R1 + R2 / slip, X)  # (2.118)
    assert at_slip(m, slip) == pytest.approx(3 * R2 * m.voltage**2 / (slip * w * ((R1 + R2 / slip) ** 2 + X**2)), rel=EXACT)
    power = at_slip(m, slip) * w * (1 - slip)
    assert power == pytest.approx(3 * R2 * current**2 * (1 - slip) / slip, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("slip", [-0.1, 0.03, 0.2, 1.0])
def test_the_magnetising_branch_vanishes_as_one_over_its_reactance(slip):
    """``errata.md``, (2.118): left out is I_0, an error of the first order in X_1/X_h. Order measured, 1 to 1 %."""
    m = motor()
    errors = [abs(circuit_torque(m, slip, x) / at_slip(m, slip) - 1) for x in (1e3, 1e4, 1e5)]
    assert errors[0] < 5e-3
    assert np.diff(np.log10(errors)) == pytest.approx([-1, -1], abs=0.01)


@pytest.mark.slow
@some
@given(m=MOTORS)
def test_the_breakdown_torque_is_the_maximum(m):
    """(2.120) as corrected, and (2.121), against a numerical maximum: its torque to 1e-9, its slip to the root of that."""
    slip, speed, torque = m.breakdown()
    maximum = minimize_scalar(
        lambda s: -abs(at_slip(m, s)), bounds=(slip / 3, 3 * slip), method="bounded", options={"xatol": 1e-7}
    )
    assert maximum.x == pytest.approx(slip, rel=1e-4)
    assert -maximum.fun == pytest.approx(abs(torque), rel=1e-9)
    assert m.torque_at(speed) == pytest.approx(torque, rel=1e-9)
    assert m.linearisation(speed)[0] == pytest.approx(0.0, abs=1e-9 * abs(torque / m.synchronous_speed()))


def test_the_breakdown_torque_as_printed_is_wrong():
    """(2.120) as printed has R_2 in the numerator; the breakdown torque does not depend on the rotor's resistance."""
    assert motor().breakdown()[2] == pytest.approx(motor(rotor_resistance=0.9).breakdown()[2], rel=EXACT)


@some
@given(m=MOTORS, slip=numbers(-1, 2))
def test_the_tangent_of_the_induction_motor(m, slip):
    """The linearised characteristic, end of section 2.2.2: against central differences, good to h^2."""
    synchronous = m.synchronous_speed()
    speed, h = synchronous * (1 - slip), 1e-5 * abs(synchronous)
    slope, no_load = m.linearisation(speed)
    largest = abs(m.breakdown()[2] / synchronous)
    assert slope == pytest.approx(-(m.torque_at(speed + h) - m.torque_at(speed - h)) / (2 * h), rel=1e-4, abs=1e-4 * largest)
    assume(abs(slope) > 1e-6 * largest)
    assert slope * (no_load - speed) == pytest.approx(m.torque_at(speed), rel=1e-8, abs=1e-8)


def test_near_its_synchronous_speed_the_motor_is_a_line():
    """There the slope is 3 U^2/(R_2 w_s^2), the limit of (2.119) for small slip, and the no-load speed w_s."""
    m = motor()
    slope = 3 * m.voltage**2 / (m.rotor_resistance * m.synchronous_speed() ** 2)
    assert m.linearisation(m.synchronous_speed()) == pytest.approx((slope, m.synchronous_speed()), rel=EXACT)
