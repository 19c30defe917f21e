"""Exciters at their resonance: the load that their beating makes, their design for one, and specimens that fail on them."""
