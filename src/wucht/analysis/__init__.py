"""A machine without running it: statics, free and forced vibration, averaged equations, steady phase configurations."""
