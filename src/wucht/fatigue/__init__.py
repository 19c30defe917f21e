"""Load histories -> spectra and damage: turning points, counting methods, classes, Woehler lines. Knows no machine."""
