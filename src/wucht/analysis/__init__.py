"""Numbers of a machine without running it: statics, free and forced vibration, averaged equations, constant phases."""
