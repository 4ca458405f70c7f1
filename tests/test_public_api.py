"""Each public name exists, is explained, appears once, and costs nothing until it is used."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import freebody as fb

NAMES = sorted(set(fb.__all__) - {"__version__"})
MODULES = ("errors", "exact", "forms", "plot", "testing")


@pytest.mark.parametrize("name", NAMES)
def test_name_resolves_and_is_explained(name: str) -> None:
    thing = getattr(fb, name)
    assert (thing.__doc__ or "").strip(), f"{name} has no docstring"
    assert isinstance(thing, ModuleType) == (name in MODULES)
    assert callable(thing) or isinstance(thing, ModuleType)


def test_names_appear_once() -> None:
    assert len(fb.__all__) == len(set(fb.__all__))
    objects = [id(getattr(fb, name)) for name in NAMES]
    assert len(objects) == len(set(objects))
    assert set(NAMES) <= set(dir(fb))


def test_a_type_checker_sees_the_same_names() -> None:
    """The imports under TYPE_CHECKING name what the lazy table names, from the same modules."""
    tree = ast.parse(Path(fb.__file__).read_text(encoding="utf-8"))
    block = next(
        node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    )
    seen = {}
    for node in block.body:
        assert isinstance(node, ast.ImportFrom) and node.level == 1
        for alias in node.names:
            public = alias.asname or alias.name
            if public in MODULES:
                seen[public] = f"{node.module}.{alias.name}:" if node.module else f"{alias.name}:"
            else:
                seen[public] = f"{node.module}" if alias.name == public else f"{node.module}:{alias.name}"
    assert seen == fb._EXPORTS


def test_an_unknown_name_gets_the_nearest() -> None:
    with pytest.raises(AttributeError, match="Expected a public name .* got 'Sistem'; did you mean 'System'"):
        _ = fb.Sistem  # type: ignore[attr-defined]


def test_version() -> None:
    assert fb.__version__.count(".") == 2


def python(code: str) -> str:
    here = {**os.environ, "PYTHONPATH": str(Path(fb.__file__).parents[1])}
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, env=here
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_import_loads_nothing_heavy() -> None:
    heavy = ["numpy", "scipy", "sympy", "flint", "llvmlite", "matplotlib", "xarray", "click", "rich"]
    loaded = python(f"import sys, freebody; print([m for m in {heavy} if m in sys.modules])")
    assert loaded == "[]"


def test_import_takes_no_time() -> None:
    """0.1 s is the promise; of this process, since other work shares the machine."""
    code = "from time import process_time as c; a = c(); import freebody; print(c() - a)"
    assert min(float(python(code)) for _ in range(3)) < 0.1


def test_no_folder_has_the_name_of_a_public_function() -> None:
    """Every import such as ``import freebody.symbolic.steady as room`` is then an ordinary one."""
    folders = {path.parent.name for path in Path(fb.__file__).parent.glob("*/__init__.py")}
    assert folders & set(NAMES) == {"exact", "testing"}  # public modules themselves
    assert (
        python("import freebody.symbolic.steady.steady as x; print(x.__name__)")
        == "freebody.symbolic.steady.steady"
    )


def test_the_root_is_an_ordinary_module(monkeypatch: pytest.MonkeyPatch) -> None:
    assert type(fb) is ModuleType
    before = fb.equations
    with monkeypatch.context() as patch:
        patch.setattr(fb, "equations", len)
        assert fb.equations is len
    assert fb.equations is before
