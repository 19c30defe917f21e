"""Errors that a human could make, as patches with the sentence that each makes wrong, and which test notices each."""
