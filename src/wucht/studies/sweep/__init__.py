"""The study ``sweep``: a parameter is moved slowly up and down: where the motion jumps, and where it depends on the way."""
