"""The study ``drive-failure``: each drive in turn loses its supply while the machine runs; are the rotors still synchronised?"""
