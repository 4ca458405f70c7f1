"""Constrained machines on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command as program


def run(*arguments: str) -> str:
    result = CliRunner().invoke(program, list(arguments), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_check_of_a_linkage() -> None:
    text = run("check", "four-bar")
    assert "closes a loop" in text
    assert "Constraint forces: C_x, C_y, C_z, C_Mx, C_My" in text
    assert "Closed position: beta = 0.722734, psi = 1.44547" in text
    assert "Degrees of freedom there: 0 (2 speeds, 2 independent constraints)" in text
    assert "Indeterminate reactions: C_z, A_z" in text


def test_check_of_rolling_gears_and_ropes() -> None:
    assert "Rolling" in run("check", "rolling-disk")
    assert "3 (6 speeds, 3 independent constraints, 2 of them on speeds only)" in run("check", "rolling-disk")
    assert "first = -r_2/r_1 * second" in run("check", "two-gears")
    assert "length L over 7 points" in run("check", "block-and-tackle")


def test_equations_show_constraints_and_their_forces() -> None:
    lines = run("equations", "two-gears").splitlines()
    assert "phi_1 + r_2*phi_2/r_1 = 0" in lines
    assert "Constraint forces (multipliers): mesh" in lines
    assert "Indeterminate reactions: C_z" in run("equations", "four-bar")
    assert "multipliers" not in run("equations", "two-gears", "--latex")
    assert "mesh" in run("equations", "two-gears", "--body", "pinion")


@pytest.fixture
def rail(tmp_path: Path) -> Path:
    s = fb.System("rail")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.sphere(2, 0.1))
    s.planar("plane", s.ground, ball, coordinate="x y f")
    s.constrain("x^2 + y^2 = 4", name="ring")
    path = tmp_path / "rail.toml"
    fb.write(s, path, near={"y": -1}, initial={"x": 1}, until=1)
    return path


def test_a_model_file_with_near_is_checked_and_run(rail: Path, tmp_path: Path) -> None:
    text = run("check", str(rail))
    assert "ring" in text and "y = -1.41421" in text
    assert "Degrees of freedom there: 2 (3 speeds, 1 independent constraints)" in text
    run("run", str(rail), "-o", str(tmp_path / "out"))
    assert any((tmp_path / "out").iterdir())


def test_check_says_why_a_machine_does_not_close(tmp_path: Path) -> None:
    s = fb.System("short")
    bar = s.body("bar", fb.slender_bar(1, 1))
    s.hinge("A", s.ground, bar, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", s.ground, bar, at=(3, 0, 0), to=(0.5, 0, 0))
    fb.write(s, tmp_path / "short.toml")
    text = run("check", str(tmp_path / "short.toml"))
    assert "Degrees of freedom: unknown. The constraints cannot be met near the coordinates given" in text
