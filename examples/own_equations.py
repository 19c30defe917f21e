"""Equations of one's own: Lorenz's model of the atmosphere (1984), whose three attractors are reached from three starts.

python examples/own_equations.py
"""

import xarray as xr

import wucht

EQUATIONS = {"x": "-y^2 - z^2 - a*x + a*F", "y": "x*y - y - b*x*z + G", "z": "b*x*y + x*z - z"}
PARAMETERS = {"F": 6.886, "G": 1.347, "a": 0.255, "b": 4.0}
STARTS = ({"x": 2.0, "y": 1.0}, {"x": -2.0, "y": 1.0}, {"y": 1.5, "z": 1.0})


def atmosphere() -> wucht.UserSystem:
    """The equations, as a table [system] of a study file gives them."""
    return wucht.UserSystem.from_formulas(EQUATIONS, PARAMETERS, title="The atmosphere of Lorenz 1984")


def run_from(start: dict[str, float]) -> xr.Dataset:
    """What the motion from a start tends to."""
    return wucht.run(wucht.RunUp(start=start), atmosphere())


if __name__ == "__main__":
    for start in STARTS:
        print(f"{start}: {run_from(start).wucht.summary['sentence']}")
