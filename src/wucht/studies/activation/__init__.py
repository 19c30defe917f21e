"""The study ``activation``: run-ups of a rotor with switchable pendulums, against rigid pendulums and none."""
