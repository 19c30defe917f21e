"""The units of the numbers in summaries: they are stored bare, in SI, under the names of the contract."""

from __future__ import annotations

# By the first step of their path; AMPLITUDE is a length or an angle, as the summary says of itself.
AMPLITUDE = "amplitude"
_UNITS = {
    "rad/s": (
        "final_speed", "min_speed", "max_speed", "free_speed", "start_speed", "mean_speed", "mean_speeds", "resonance_speed",
        "natural_frequencies", "speed", "runaway",
    ),
    AMPLITUDE: ("final_amplitude", "min_amplitude", "max_amplitude", "peak_amplitude"),
    "s": (
        "settling_time", "amplitude_settling_time", "modulation_period", "half_time", "reversal_time", "end_time", "until",
        "settling",
    ),
    "rad": ("final_phases", "rotor_phases", "modulation_period_phi", "max_pressure_angle", "until_phi", "throw_direction"),
    "N m": ("peak_torque",),
    "N": ("bearing_force", "bearing_forces"),
    "m/s^2": ("acceleration",),
    "m": ("min_curvature_radius", "min_hollow_radius", "base_radius", "largest_radius", "stroke"),
    "W": ("mean_power",),
}  # fmt: skip
_BY_NAME = {name: unit for unit, names in _UNITS.items() for name in names}


def unit_of_number(path: str, amplitude: str = "m", dimensionless: bool = False) -> str:
    """The unit of a number by its path in a summary; empty for a ratio, and for what is not known here.

    amplitude: the unit of amplitudes, which is rad where the carrier turns. dimensionless: of such a machine angles alone have
    one.
    """
    unit = _BY_NAME.get(path.partition(".")[0], "")
    if dimensionless and unit != "rad":
        return ""
    return amplitude if unit == AMPLITUDE else unit
