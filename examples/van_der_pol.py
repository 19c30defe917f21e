"""Equations of one's own: the orbit of van der Pol's oscillator, its period and how fast it attracts, at several strengths.

python examples/van_der_pol.py
"""

import xarray as xr

import wucht

EQUATIONS = {"x": "v", "v": "mu*(1 - x^2)*v - x"}


def orbits(strengths: list[float]) -> xr.Dataset:
    """A run at each strength, in one result."""
    oscillator = wucht.UserSystem.from_formulas(EQUATIONS, {"mu": 1.0}, title="Van der Pol's oscillator")
    return wucht.run(wucht.RunUp(start={"x": 0.1}, along="mu", values=strengths), oscillator)


if __name__ == "__main__":
    for case in orbits([0.5, 1.0, 2.0]).wucht.summary["cases"]:
        print(f"{case['label']}: period {case['period']:.6f}, multiplier {case['multipliers'][0][0]:.6f}")
