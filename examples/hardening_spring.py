"""Equations of one's own: a mass on a hardening spring is shaken (Duffing): where its amplitude jumps, up and down.

python examples/hardening_spring.py
"""

import xarray as xr

import wucht

EQUATIONS = {"x": "v", "v": "-2*d*v - x - g*x^3 + f*cos(w*t)"}
PARAMETERS = {"d": 0.03, "g": 0.1, "f": 0.15, "w": 1.0}
RANGE, POINTS = (1.0, 1.3), 61


def sweep() -> xr.Dataset:
    """The frequency is moved up and down, in steps."""
    spring = wucht.UserSystem.from_formulas(EQUATIONS, PARAMETERS, title="A hardening spring")
    return wucht.run(wucht.Sweep(along="w", range=RANGE, points=POINTS), spring)


if __name__ == "__main__":
    print(sweep().wucht.summary["sentence"])
