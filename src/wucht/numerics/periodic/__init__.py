"""Periodic orbits: branches in one parameter, Floquet multipliers, and curves of their bifurcations in two parameters."""
