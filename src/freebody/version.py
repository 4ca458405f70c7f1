"""Version of the package."""

from __future__ import annotations

from time import time_ns

VERSION = "0.1.0"
IMPORTED = time_ns()
"""Time at which this process imported the package [ns since 1970]."""
