"""The study ``phase-portrait``: fixed points, separatrices, closed curves of a planar System, as 002 figures 5.5, 5.8, A.2."""
