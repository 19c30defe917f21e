"""Engines between a machine and a study: run-ups and their verdicts, branches, ensembles. They use no spec and no figure.

A rotor on an elastic carrier, in dimensionless form, with a soft motor (slope u = 1) and with a stiff one (u = 3):

>>> import wucht
>>> from wucht.dynamics import run_to_end
>>> machine = wucht.load_machine("drozdetskaya-2020/table-3.1-carrier")
>>> for u in (1.0, 3.0):
...     verdict = run_to_end(machine.with_values({"u": u}), start={}).verdict
...     print(f"u = {u}: {verdict.outcome} at {verdict.speed:.3f}")
u = 1.0: captured at 0.916
u = 3.0: passed at 1.881
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
