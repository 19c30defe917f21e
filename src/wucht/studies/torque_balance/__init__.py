"""The study ``torque-balance``: where the drive's torque equals that of load and vibration. 002 (3.51), figure 3.2b."""
