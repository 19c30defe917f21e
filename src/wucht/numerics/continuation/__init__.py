"""Continuation: branches of equilibria and of what changes along them, for any System or any residual given as a function."""
