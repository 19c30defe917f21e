"""Linkages between the lever of the follower and the output."""
