"""Studies: a question -> a Dataset. One file or folder per question."""
