"""Settings shared by all tests."""

from __future__ import annotations

import gc
import os

import pytest
from hypothesis import settings

settings.register_profile("untimed", deadline=None)  # time depends on what else the machine does
settings.load_profile("untimed")

# threads of the numerical libraries would fight with the workers of pytest-xdist
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
os.environ.setdefault("MPLBACKEND", "Agg")


def pytest_configure() -> None:
    """Collect no garbage while tests are collected, of which all is kept."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Collect it again from here on."""
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def compiled_code_of_this_run(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Compiled kernels go to a folder of this run, unless the caller chose one."""
    if "FREEBODY_CACHE" not in os.environ:
        os.environ["FREEBODY_CACHE"] = str(tmp_path_factory.getbasetemp() / "freebody-cache")
