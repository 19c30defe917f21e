"""A dip of the supply voltage: the longest after which the machine returns by itself, and what follows a longer one."""
