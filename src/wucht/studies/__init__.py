"""Studies: a question -> a Dataset. One file a question."""
