"""Results: quantities, their Dataset and its accessor, storage and provenance."""
