"""Branches of modulated motions: periodic orbits of averaged equations, or of one's own, over a parameter."""
