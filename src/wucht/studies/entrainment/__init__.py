"""Study ``entrainment``: the band of a parameter in which rotors are entrained. 001, sections 2.2 and 2.3."""
