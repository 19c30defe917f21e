"""Cams: motion laws, followers and contours, and the cam that makes a clean motion on a shaft that does not turn evenly."""
