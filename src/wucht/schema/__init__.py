"""Schema: frozen tables with units, their keys and help texts, checking with located errors, units at the edge.

A table with a length, as of a part of a machine or a study:

>>> from wucht.schema import TableModel, keys_of, si
>>> class Spacer(TableModel):
...     length: float = si("m", "length", gt=0)
>>> Spacer(length="20 mm").length
0.02
>>> [(key.name, key.unit, key.allowed, key.what) for key in keys_of(Spacer)]
[('length', 'm', '> 0', 'length')]
"""

from wucht.schema.checking import (
    choice,
    fields_of,
    is_pairs,
    locate_error,
    models_in,
    read_quantity,
    refuse_unknown,
    require_table,
    text,
    unit_of,
    validate_table,
)
from wucht.schema.fields import SI, Composite, Conversion, Parameter, TableModel, composite, full_name, si
from wucht.schema.keys import Key, keys_of
from wucht.schema.python_values import python_value
from wucht.schema.signature import prose_of
from wucht.schema.units import LARGEST, SMALLEST, Unit, article

__all__ = [
    "LARGEST", "SI", "SMALLEST", "Composite", "Conversion", "Key", "Parameter", "TableModel", "Unit", "article", "choice",
    "composite", "fields_of", "full_name", "is_pairs", "keys_of", "locate_error", "models_in", "prose_of", "python_value",
    "read_quantity", "refuse_unknown", "require_table", "si", "text", "unit_of", "validate_table",
]  # fmt: skip
