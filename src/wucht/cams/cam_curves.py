"""The curves of a cam over the cam angle, as they are shown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import Cam


@dataclass(frozen=True, eq=False)
class CamCurves:
    """Curves of a cam over cam angles (N,): contour, pitch (not numbers for a flat face), normal: complex, in m.

    normal: away from the cam's centre. curvature: in 1/m, positive where the contour is convex. uncut: margin against undercut,
    see ``Cam.undercut``. pressure_angle: in rad.
    """

    contour: np.ndarray
    pitch: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    uncut: np.ndarray
    pressure_angle: np.ndarray

    @classmethod
    def of(cls, cam: Cam, phi: np.ndarray) -> CamCurves:
        """Return the curves of a cam at cam angles (N,)."""
        contour, normal = cam.contour(phi), cam.normal(phi)
        pitch = np.full(len(phi), np.nan + 0j) if cam.pitch_curve is None else cam.pitch_curve(phi, 0)
        return cls(contour, pitch, normal, cam.material * cam.curvature(phi), cam.undercut(phi), cam.pressure_angle(phi))
