"""The study ``sweep``: move a parameter slowly up and down, and find where the machine jumps."""
