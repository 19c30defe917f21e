"""The speed of a camshaft without a measurement, and the cam corrected for it before anything is built."""
