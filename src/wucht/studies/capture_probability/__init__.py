"""The study ``capture-probability``: probability that a machine with random starts and tolerances passes its resonance."""
