"""System -> motion: compiled once per structure, integrated any number of times, in machine code.

A pendulum of frequency w, with the times at which it swings through its lowest position to the right:

>>> import numpy as np
>>> import sympy as sp
>>> from wucht.numerics.flow import Event, System, compile_system, integrate
>>> angle, speed, w = sp.symbols("angle speed w", real=True)
>>> pendulum = System((angle, speed), (speed, -(w**2) * sp.sin(angle)), (w,))
>>> compiled = compile_system(pendulum, events=(Event("lowest", angle, direction=1),))
>>> run = integrate(compiled, [1.0, 0.0], {"w": 2.0}, np.linspace(0.0, 10.0, 101))
>>> [round(hit.time, 6) for hit in run.hits]
[2.512491, 5.862479, 9.212467]

Compilation: ``System``, ``TIME``, ``compile_system``, ``CompiledSystem``, ``DEFAULT_TOLERANCE``. Runs:
``integrate``, ``Trajectory``, ``Event``, ``Hit``. Expressions over arrays: ``Evaluator``.
"""

import lazy_loader

from wucht.earlier_names import provide_earlier_names

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

provide_earlier_names(__name__)
