"""Energies to equations, and averaged equations: symbolic, without numbers.

Duffing's oscillator from its energies, and its averaged amplitude r and phase psi, x = r cos(t + psi):

>>> import sympy as sp
>>> from wucht.mechanics import Coordinate, Energies, averaged, equations_of_motion, first_order, with_amplitude_and_phase
>>> c, (mu, r, psi) = Coordinate.from_names("x", "v"), sp.symbols("mu r psi", real=True)
>>> x, v = c.position, c.velocity
>>> oscillator = Energies(kinetic=v**2 / 2, potential=x**2 / 2 + mu * x**4 / 4)
>>> duffing = first_order(equations_of_motion([oscillator], [c]), [c], [mu])
>>> averaged(with_amplitude_and_phase(duffing, x, v, sp.S.One, r, psi), mu).system.derivatives
(0, 3*mu*r**2/8)
"""

import lazy_loader

from wucht.earlier_names import provide_earlier_names

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
provide_earlier_names(__name__)
