"""Measured records -> numbers: reading files, speed of a shaft, orders by least squares, order tracking. Knows no machine.

The mean speed of a shaft and the second order of its fluctuation, from a record of its speed:

>>> import numpy as np
>>> from wucht.measurements import Channel, fit_orders, speed_signal
>>> time = np.linspace(0.0, 2.0, 4000)
>>> record = Channel("bench.csv", "speed", "rad/s", time, 50 + 2 * np.cos(50 * time) + np.sin(100 * time))
>>> fit = fit_orders(speed_signal(record), orders=[1, 2])
>>> print(f"{fit.speed.mean:.3f} rad/s; order 2: {fit.cosine[1]:.3f} cos + {fit.sine[1]:.3f} sin")
50.000 rad/s; order 2: 0.000 cos + 1.000 sin
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
