"""Plots: what figures share, from the page to lines by stability. They know Datasets, and no study."""
