"""The study ``drive-failure``: each drive in turn loses its supply in operation; are the rotors still synchronised?"""
