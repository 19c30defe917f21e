"""Cams: motion laws, followers and contours, and the cam that makes a clean motion on a shaft that does not turn evenly.

A rod with a roller that rises by 10 mm over 90 degrees of the cam and returns over the last 90 degrees:

>>> import numpy as np
>>> from wucht.cams import RiseAndReturn, TranslatingRoller, shapes, standard_law
>>> law = RiseAndReturn(standard_law("3-4-5"), stroke=0.01, rise=(0.0, np.pi / 2))
>>> cams = TranslatingRoller(distance="40 mm", roller_radius="8 mm").make_cams(law)
>>> shape = shapes(cams)["cam"]
>>> print(f"largest pressure angle {np.degrees(shape.pressure_angle.value):.1f} deg, radius {1e3 * shape.convex.radius:.1f} mm")
largest pressure angle 14.9 deg, radius 25.4 mm
>>> print(np.round(1e3 * abs(cams["cam"].contour(np.array([0.0, np.pi / 2]))), 6))
[32. 42.]
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
