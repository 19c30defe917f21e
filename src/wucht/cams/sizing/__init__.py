"""The smallest cam that will do."""
