"""Exciters at resonance: the load spectrum of their beats, the design for a spectrum, and specimens that fail on them."""
