"""Several machines or variants side by side: each one's study, in one result."""
