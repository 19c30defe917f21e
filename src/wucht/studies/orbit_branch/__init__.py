"""Branches of modulated motions: periodic orbits of averaged equations, or of user equations, over a parameter."""
