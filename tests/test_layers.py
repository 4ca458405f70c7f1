"""Data flows down the layers: the import contracts of pyproject.toml hold."""

from __future__ import annotations

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_import_contracts() -> None:
    from importlinter.cli import lint_imports

    assert lint_imports(config_filename=str(ROOT / "pyproject.toml"), no_cache=True) == 0


def test_every_folder_is_in_the_contract() -> None:
    with (ROOT / "pyproject.toml").open("rb") as stream:
        contracts = tomllib.load(stream)["tool"]["importlinter"]["contracts"]
    layers = {name.strip(" ()") for line in contracts[0]["layers"] for name in line.split("|")}
    folders = {f"freebody.{p.parent.name}" for p in (ROOT / "src" / "freebody").glob("*/__init__.py")}
    assert folders - layers == {"freebody.exact"}  # it has a contract of its own: it imports no room at all
