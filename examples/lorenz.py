"""Equations of one's own: Lorenz's convection (1963). At r = 10 each start leads to one of two equilibria, at r = 28 to chaos.

python examples/lorenz.py
"""

import xarray as xr

import wucht

EQUATIONS = {"x": "s*(y - x)", "y": "r*x - y - x*z", "z": "x*y - b*z"}


def convection(r: float) -> wucht.UserSystem:
    """The equations with a heating r."""
    return wucht.UserSystem.from_formulas(EQUATIONS, {"s": 10.0, "r": r, "b": 8 / 3}, title="Lorenz 1963")


def basins(r: float = 10.0, cells: int = 16) -> xr.Dataset:
    """Which attractor each start leads to, over x and y at z = 0."""
    return wucht.run(wucht.Basin(axes={"x": (-20, 20, cells), "y": (-20, 20, cells)}, refine=1), convection(r))


def motion(r: float = 28.0) -> xr.Dataset:
    """What the motion from a start tends to."""
    return wucht.run(wucht.RunUp(start={"x": 1.0, "y": 1.0, "z": 1.0}), convection(r))


if __name__ == "__main__":
    print(basins().wucht.summary["sentence"])
    print(motion().wucht.summary["sentence"])
