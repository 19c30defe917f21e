"""Observers of a motion while it runs: updated part by part, in bounded memory, with results independent of the parts."""
