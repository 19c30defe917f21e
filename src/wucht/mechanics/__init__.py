"""Energies to equations: symbolic, without numbers."""
