"""Energies to equations: symbolic, and no number is computed here."""
