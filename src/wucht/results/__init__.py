"""Results: quantities, the Dataset that they make and what it says of itself, store and provenance."""
