"""A machine with one parameter that is moved while it runs: how slowly, what is read off it, and where its branches end."""
