"""Systems of AUTO-07p's demos, which peers' numbers are known of: E. J. Doedel et al., AUTO-07P manual, 2007."""

from __future__ import annotations

import sympy as sp

from wucht.system import System

_U1, _U2, _X, _Y, _Z = sp.symbols("u1 u2 x y z", real=True)
_P1, _P2, _RHO, _Q = sp.symbols("p1 p2 rho q", real=True)

AB = System(
    (_U1, _U2),
    (-_U1 + _P1 * (1 - _U1) * sp.exp(_U2), -_U2 + _P1 * _P2 * (1 - _U1) * sp.exp(_U2) - 3 * _U2),
    (_P1, _P2),
)
LORENZ = System((_X, _Y, _Z), (10 * (_Y - _X), _RHO * _X - _Y - _X * _Z, _X * _Y - sp.Rational(8, 3) * _Z), (_RHO,))
PP2 = System((_U1, _U2), (3 * _U1 * (1 - _U1) - _U1 * _U2 - _Q * (1 - sp.exp(-5 * _U1)), -_U2 + 3 * _U1 * _U2), (_Q,))

_ANGLE1, _ANGLE2, _V1, _V2, _CURRENT, _GAMMA, _EPS = sp.symbols("phi1 phi2 v1 v2 current gamma eps", real=True)
PEN = System(
    (_ANGLE1, _ANGLE2, _V1, _V2),
    (
        _V1,
        _V2,
        -_EPS * _V1 - sp.sin(_ANGLE1) + _CURRENT + _GAMMA * (_ANGLE2 - _ANGLE1),
        -_EPS * _V2 - sp.sin(_ANGLE2) + _CURRENT + _GAMMA * (_ANGLE1 - _ANGLE2),
    ),
    (_CURRENT, _GAMMA, _EPS),
    angles=frozenset({_ANGLE1, _ANGLE2}),
)

_S, _A, _S0 = sp.symbols("s a S0", real=True)
_REACTION = _RHO * _S * _A / (1 + _S + _S**2 / 10)
PLP = System((_S, _A), (_S0 - _S - _REACTION, (500 - _A) / 5 - _REACTION), (_RHO, _S0))
"""At S0 = 111 a closed branch of orbits over rho, where no equilibrium is unstable."""

_NU, _BE, _R, _GA = sp.symbols("nu be r ga", real=True)
_CUBIC = sp.Float("0.933578") * (_Y - _X) ** 3
CIR = System(
    (_X, _Y, _Z),
    (
        (-(_BE + _NU) * _X + _BE * _Y - sp.Float("0.328578") * _X**3 + _CUBIC) / _R,
        _BE * _X - (_BE + _GA) * _Y - _Z - _CUBIC,
        _Y,
    ),
    (_NU, _BE, _R, _GA),
)
"""The equations of the demo tor which the demo cir has, too: E. Freire, A. J. Rodriguez-Luis, E. Gamero, E. Ponce,
Physica D 62 (1993) 230-253."""

TOR = System(CIR.states, tuple(d.subs({_R: sp.Float("0.6"), _GA: sp.Float("-0.6")}) for d in CIR.derivatives), (_NU, _BE))
"""Symmetric under (x, y, z) -> -(x, y, z)."""
