"""Boundary value problems by orthogonal collocation: what periodic orbits and connections of saddles are computed with."""
