"""Results: the Dataset's conventions, outcome labels, store and provenance."""
