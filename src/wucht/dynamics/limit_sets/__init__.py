"""What motions of differential equations tend to: equilibria, periodic orbits, tori, chaotic attractors; and their basins."""
