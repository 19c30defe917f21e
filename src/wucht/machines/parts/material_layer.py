"""The layer of material on a screen or conveyor, as a part of its mass that moves with it, and damping."""

from __future__ import annotations

from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import SI, Frame, si
from wucht.mechanics.energies import Energies


class MaterialLayer(Attachment):
    """Material that is thrown and lands again: its weight, a share of its mass that vibrates along, and damping.

    The first harmonic of the force with which a layer that never rebounds (the completely inelastic bouncing ball: A. Mehta,
    J. M. Luck, Phys. Rev. Lett. 65 (1990) 393-396) acts on a deck y = a sin(omega t) is that of the mass ``share`` m and of
    the damper ``damping`` = beta m omega. Both depend on the throw number Gamma = a omega^2/g alone: docs/machine-files.md has
    them. So they hold at one amplitude and one frequency, across the deck; the same is taken along it. What the layer does at
    other frequencies, its spreading over the deck and the change of its mass over time are left out.
    """

    kind = "material-layer"

    mass: SI[float] = si("kg", "mass of the material on the deck", "m", gt=0)
    share: SI[float] = si("", "share of the material that vibrates with the deck", "kappa", ge=0, le=1)
    damping: SI[float] = si("N s/m", "damping", "b", default=0.0, ge=0, help="damping by the material on the deck")

    def energies(self, frame: Frame) -> Energies:
        """T = kappa m v^2/2, V = m g y: in the mean the deck bears all of the weight; R = b v^2/2."""
        m, share, b = self.symbols("mass", "share", "damping")
        at = frame.axis(self.name)
        square = at.vx**2 + at.vy**2
        return Energies(share * m * square / 2, m * frame.gravity * at.y, b * square / 2)
