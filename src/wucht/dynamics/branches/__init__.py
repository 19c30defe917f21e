"""Branches of steady states and of periodic orbits over one and two parameters, and how they end."""
