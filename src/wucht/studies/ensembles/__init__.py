"""What becomes of many starts and variants of one machine: the run-up's criteria, for thousands of members at once."""
