"""Boundary value problems by orthogonal collocation: the method behind periodic orbits and connections of saddles."""
