"""Load histories -> spectra and damage: turning points, counting methods, classes, Woehler lines. Knows no machine.

The example of ASTM E1049-85: its rainflow cycles, and the damage that they do.

>>> from wucht.fatigue import WoehlerLine, rainflow
>>> cycles = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
>>> rows, _ = cycles.group_by_range()
>>> dict(zip(rows.ranges.tolist(), rows.counts.tolist()))
{3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
>>> damage = WoehlerLine(k=5, ND=2e6, SD=3.0, k2=9).damages(cycles).sum()
>>> print(f"{damage:.4e}")
4.2754e-06
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
