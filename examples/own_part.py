"""A new part is one class: a motor whose torque falls with the square of the speed, here on an unbalanced rotor.

python examples/own_part.py
"""

from typing import ClassVar

import sympy as sp

from wucht import RunUp, parts
from wucht.extending import SI, Drive, Machine, run, si


class QuadraticDrive(Drive):
    """torque = stall_torque (1 - (speed/no_load_speed)^2)."""

    kind: ClassVar[str] = "quadratic"

    stall_torque: SI[float] = si("N m", "torque at standstill", "T_0", gt=0)
    no_load_speed: SI[float] = si("rad/s", "no-load speed", "omega_0", gt=0)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """The motor's torque at a speed."""
        stall, no_load = self.symbols("stall_torque", "no_load_speed")
        return stall * (1 - (speed / no_load) ** 2)


def main(stall_torque: str = "2 N m") -> tuple[str, float]:
    """Run up the rotor and return the outcome and the final speed."""
    machine = Machine(
        parts.Carrier(stiffness="1e5 N/m", damping="200 N s/m"),
        [parts.Rotor(name="drum", mass="10 kg", eccentricity="1 mm", inertia="0.03 kg m^2")],
        [QuadraticDrive(stall_torque=stall_torque, no_load_speed="200 rad/s")],
        title="rotor with a motor of our own",
    )
    result = run(RunUp(), machine)
    return str(result.attrs["outcome"]), float(result.speed[0, -1])


if __name__ == "__main__":
    for torque in ("0.3 N m", "1 N m", "10 N m"):
        outcome, speed = main(torque)
        print(f"{torque}: {outcome} at {speed:.4g} rad/s")
