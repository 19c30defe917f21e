"""Periodic orbits: their branches in one parameter, their multipliers, and the curves where these change in two."""
