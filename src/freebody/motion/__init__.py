"""Motion of a machine: simulation, events, trajectory, batches."""

from functools import partial as _partial
from importlib import import_module as _import_module

from .trajectory import file_access as _file_access

for _name in ("save", "load"):
    _file_access.register(_name, _partial(_import_module, f"{__name__}.files.{_name}"))
