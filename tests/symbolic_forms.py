"""Normal forms from symbolic derivatives, as independent witnesses of those by differences."""

from __future__ import annotations

from itertools import product

import numpy as np
import sympy as sp

from wucht.system import System


def forms(system: System, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A (n, n), B (n, n, n) and C (n, n, n, n) at u = (x, parameters in the System's order)."""
    states = system.states
    at = dict(zip((*states, *system.parameters), map(sp.Float, u.tolist()), strict=True))
    n = len(states)
    every = [np.zeros((n,) * (order + 1)) for order in (1, 2, 3)]
    for order, tensor in enumerate(every, 1):
        for i, *along in product(range(n), repeat=order + 1):
            tensor[(i, *along)] = float(sp.diff(system.derivatives[i], *(states[k] for k in along)).evalf(subs=at))
    return every[0], every[1], every[2]


def planar_lyapunov(system: System, u: np.ndarray) -> tuple[float, float]:
    """omega and l1 of a planar Hopf point by J. Guckenheimer, P. Holmes, "Nonlinear Oscillations", Springer 1983, (3.4.11).

    There r' = a r^3 in coordinates (x, y) = 2 (Re z, Im z), state = z q + its conjugate, |q| = 1: l1 = 4 a / omega.
    """
    A, B, C = forms(system, u)
    values, vectors = np.linalg.eig(A)
    k = int(values.imag.argmax())
    omega, q = float(values[k].imag), vectors[:, k] / np.linalg.norm(vectors[:, k])
    T = np.stack([q.real, -q.imag], axis=1)
    S = np.linalg.inv(T)
    f, g = np.einsum("ai,ijk,jb,kc->abc", S, B, T, T)
    ff, gg = np.einsum("ai,ijkl,jb,kc,ld->abcd", S, C, T, T, T)
    a = (ff[0, 0, 0] + ff[0, 1, 1] + gg[0, 0, 1] + gg[1, 1, 1]) / 16
    a += (f[0, 1] * (f[0, 0] + f[1, 1]) - g[0, 1] * (g[0, 0] + g[1, 1]) - f[0, 0] * g[0, 0] + f[1, 1] * g[1, 1]) / (16 * omega)
    return omega, 4 * a / omega


def tensor_lyapunov(system: System, u: np.ndarray) -> float:
    """l1 by Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", Springer 2004, (5.39), |q| = 1."""
    A, B, C = forms(system, u)
    values, right = np.linalg.eig(A)
    k = int(np.where(values.imag > 0, -np.abs(values.real), -np.inf).argmax())
    omega, q = float(values[k].imag), right[:, k] / np.linalg.norm(right[:, k])
    adjoint, left = np.linalg.eig(A.T)
    p = left[:, np.abs(adjoint + 1j * omega).argmin()]
    p = p / np.conj(np.vdot(p, q))
    both = lambda a, b: np.einsum("ijk,j,k", B, a, b)  # noqa: E731
    one = np.einsum("ijkl,j,k,l", C, q, q, q.conj())
    two = both(q, np.linalg.solve(A, both(q, q.conj())))
    three = both(q.conj(), np.linalg.solve(2j * omega * np.eye(len(A)) - A, both(q, q)))
    return float((np.vdot(p, one) - 2 * np.vdot(p, two) + np.vdot(p, three)).real / (2 * omega))
