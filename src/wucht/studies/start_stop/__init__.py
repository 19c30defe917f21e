"""The study ``start-stop``: a cycle of the machine up and down, with its vibration, loads, energy and damage."""
