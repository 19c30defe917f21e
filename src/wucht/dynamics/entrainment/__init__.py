"""Rotors entrained by a vibration or by each other: bands of existence, runs from a start, locked motions."""
