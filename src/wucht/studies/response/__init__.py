"""The study ``response``: the steady forced vibration over the speed, the unbalance fixed. 002 (2.74)-(2.79)."""
