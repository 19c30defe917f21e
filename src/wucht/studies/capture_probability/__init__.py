"""The study ``capture-probability``: how likely a machine with random starts and tolerances gets through."""
