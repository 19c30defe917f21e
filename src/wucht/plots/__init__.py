"""Plots: the common parts of figures, from the page to lines by stability. They know Datasets, and no study."""
