"""The motion law of a cam drive: synthesised, standard or given, with its derivatives and its spectrum."""
