"""Kinds of followers, one a file: how the law of a motion moves what runs on a cam, and the cams of each."""
