"""The tables of a cam file, checked when they are built, and the objects they describe."""
