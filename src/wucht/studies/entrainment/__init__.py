"""The study ``entrainment``: in which band of a parameter rotors are entrained. 001, sections 2.2 and 2.3."""
