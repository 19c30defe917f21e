"""What is seen of a motion while it runs: fed part by part, in bounded memory, the same whatever the parts are."""
