"""``python -m benchmarks [NAME ...] [--quick] [--repeats N] [--limit SECONDS]``."""

from __future__ import annotations

import argparse
from importlib import import_module

from .tables import versions

NAMES = (
    "equations", "linearize", "dynamics", "motion", "precision", "sweep", "references", "contact", "piles", "report",
    "first", "studies", "rows", "formulas", "robots",
)  # fmt: skip
MODULES = {"references": "problems"}  # those named otherwise


def main() -> None:
    """Print the tables that are asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="freebody beside its peers")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(NAMES)}; all if none")
    parser.add_argument("--quick", action="store_true", help="fewer sizes and settings")
    parser.add_argument("--repeats", type=int, default=5, help="repeats of each measurement (median)")
    parser.add_argument(
        "--limit", type=float, default=None, help="seconds allowed to SymPy's simplify per case"
    )
    options = parser.parse_args()
    for name in options.names:
        if name not in NAMES:
            parser.error(f"unknown benchmark '{name}'; choose from {', '.join(NAMES)}")
    limit = options.limit if options.limit is not None else (20.0 if options.quick else 185.0)
    print(versions() + "\n")
    for name in options.names or NAMES:
        module = import_module(f"benchmarks.{MODULES.get(name, name)}")
        module.main(quick=options.quick, repeats=options.repeats, limit=limit)


if __name__ == "__main__":
    main()
