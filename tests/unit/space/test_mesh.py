"""Meshes: the integrals against solids, what a file gives, and the refusals."""

from __future__ import annotations

import sys

import numpy as np
import pytest
import sympy
from scipy.spatial import ConvexHull

from freebody.errors import FormatError, MassError
from freebody.space.mesh import mesh
from freebody.space.rotation import Rotation
from freebody.space.solids import box, sphere

CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 2) for k in (0, 3)], float)


def outward(points):
    """Triangles of the convex hull, counter-clockwise seen from outside."""
    faces = ConvexHull(points).simplices.copy()
    inside = points.mean(axis=0)
    for face in faces:
        p, q, r = points[face]
        if np.dot(np.cross(q - p, r - p), p - inside) < 0:
            face[:] = face[::-1]
    return faces


BOX = outward(CORNERS)


def ball(n):
    """A polyhedron with n vertices on the unit sphere (a Fibonacci lattice)."""
    i = np.arange(n) + 0.5
    z, phi = 1 - 2 * i / n, np.pi * (1 + 5**0.5) * i
    points = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)
    return points, outward(points)


def test_a_cube_is_a_box_exactly():
    found = mesh(CORNERS, BOX, mass=12)
    assert found == box(12, (1, 2, 3)).moved((0.5, 1, 1.5))
    assert mesh(CORNERS, BOX, density=2).mass == 12


def test_a_turned_cube_far_away():
    R = np.array(Rotation.euler("ZXZ", 0.3, 1.0, -0.7))
    points = CORNERS @ R.T + [1000, -2000, 500]
    expected = R @ np.diag([13.0, 10, 5]) @ R.T
    found = mesh(points, BOX, mass=12)
    # The vertices themselves are rounded to 1e-13 of the size here.
    assert np.abs(np.array(found.inertia, float) - expected).max() < 1e-10
    center = R @ [0.5, 1, 1.5] + [1000, -2000, 500]
    assert np.array(found.center, float) == pytest.approx(center, abs=1e-12)


def test_density_may_be_a_symbol():
    rho = sympy.Symbol("rho", real=True)
    found = mesh(CORNERS, BOX, density=rho)
    assert found.mass == 6 * rho and found.moments == (
        sympy.Rational(13, 2) * rho,
        5 * rho,
        sympy.Rational(5, 2) * rho,
    )
    assert found.positive == (rho,)


def test_a_polyhedron_tends_to_the_ball():
    errors = []
    for n in (250, 1000):
        found = mesh(*ball(n), density=1)
        errors.append(abs(float(found.mass) - 4 * np.pi / 3))
        assert float(found.moments[0]) == pytest.approx(float(sphere(found.mass, 1).moments[0]), rel=12 / n)
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)  # second order in the edge


def test_a_cavity_counts_as_a_hole():
    inner = CORNERS / 2 + [0.25, 0.5, 0.75]
    points, faces = np.vstack([CORNERS, inner]), np.vstack([BOX, BOX[:, ::-1] + 8])
    hollow = box(12, (1, 2, 3)).moved((0.5, 1, 1.5)) - box(1.5, (0.5, 1, 1.5)).moved((0.5, 1, 1.5))
    found = mesh(points, faces, density=2)
    assert found.mass == hollow.mass == 10.5
    assert np.array(found.inertia, float) == pytest.approx(np.array(hollow.inertia, float), rel=1e-15)


def test_repeated_vertices_are_one():
    points = CORNERS[BOX].reshape(-1, 3)
    assert mesh(points, np.arange(len(points)).reshape(-1, 3), mass=12) == mesh(CORNERS, BOX, mass=12)


def test_scale_and_flip():
    found = mesh(CORNERS * 1000, BOX[:, ::-1], mass=12, scale=0.001, flip=True)
    assert np.array(found.inertia, float) == pytest.approx(np.diag([13, 10, 5]), abs=1e-14)
    assert found.shape["surface"].faces.tolist() == BOX.tolist()


def test_shape_is_kept_for_drawing():
    shape = mesh(CORNERS, BOX, mass=1).moved((1, 0, 0)).shape
    assert shape.kind == "mesh" and shape.center == (1, 0, 0)
    assert shape["surface"].vertices.shape == (8, 3) and not shape["surface"].vertices.flags.writeable


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".off"])
def test_files(tmp_path, suffix):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / f"box{suffix}"
    trimesh.Trimesh(CORNERS, BOX, process=False).export(path)
    found = mesh(path, mass=12)
    expected = box(12, (1, 2, 3)).moved((0.5, 1, 1.5))
    assert np.array(found.inertia, float) == pytest.approx(np.array(expected.inertia, float), abs=1e-14)
    assert np.array(found.center, float) == pytest.approx([0.5, 1, 1.5], abs=1e-15)
    assert mesh(str(path), density=1).mass == 6


def test_agrees_with_trimesh():
    trimesh = pytest.importorskip("trimesh")
    solid = trimesh.creation.torus(2.0, 0.5)
    found = mesh(solid.vertices, solid.faces, density=1)
    assert float(found.mass) == pytest.approx(solid.volume, rel=1e-13)
    assert np.array(found.inertia, float) == pytest.approx(solid.moment_inertia, abs=1e-11)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: mesh(CORNERS, BOX[1:], mass=1),
            "a closed mesh, got one with 3 open edges of 18.*Fill the holes",
        ),
        (
            lambda: mesh(CORNERS, np.vstack([BOX[1:], BOX[:1, ::-1]]), mass=1),
            "triangles that all turn the same way, got 3 edges run through twice in one sense",
        ),
        (
            lambda: mesh(CORNERS, BOX[:, ::-1], mass=1),
            r"got a mesh that is inside out \(volume -6 m³\).*flip=True",
        ),
        (
            lambda: mesh(CORNERS * [1, 1, 0], BOX, mass=1),
            "a mesh that encloses a volume, got 0 m³ at a size of 2 m",
        ),
        (lambda: mesh(CORNERS[:, :2], BOX, mass=1), r"vertices with shape \(n, 3\), got shape \(8, 2\)"),
        (lambda: mesh([["a", 0, 0]], BOX, mass=1), "vertices as numbers with shape"),
        (lambda: mesh(CORNERS * np.nan, BOX, mass=1), "finite vertices, got"),
        (lambda: mesh(CORNERS, BOX[:, :2], mass=1), r"faces with shape \(k, 3\), got shape \(12, 2\)"),
        (
            lambda: mesh(CORNERS, [[0, 1, 2], [0, 1]], mass=1),
            r"faces with shape \(k, 3\), got rows of different lengths",
        ),
        (lambda: mesh(CORNERS, BOX * 1.0, mass=1), "faces as integers .*got float64"),
        (lambda: mesh(CORNERS, BOX + 1, mass=1), "vertex numbers 0 to 7, got 8. Counting starts at 0"),
        (lambda: mesh(CORNERS, BOX - 1, mass=1), "vertex numbers 0 to 7, got -1"),
        (lambda: mesh(CORNERS, mass=1), "faces beside the vertices"),
        (lambda: mesh(CORNERS, BOX), "either mass= or density= of the mesh, got both or none"),
        (
            lambda: mesh(CORNERS, BOX, mass=1, density=1),
            "either mass= or density= of the mesh, got both or none",
        ),
        (lambda: mesh(CORNERS, BOX, mass=1, scale=-1), "a scale that is a number above zero, got -1"),
        (lambda: mesh(CORNERS, BOX, mass=-1), "mass that is not negative, got -1"),
        (lambda: mesh("box.stl", BOX, mass=1), "a path alone, or vertices and faces"),
    ],
)
def test_refusals(make, message):
    with pytest.raises(MassError, match=message):
        make()


def test_unreadable_files(tmp_path):
    pytest.importorskip("trimesh")
    with pytest.raises(FormatError, match="a triangle mesh in '.*missing.stl', but there is no such file"):
        mesh(tmp_path / "missing.stl", mass=1)
    broken = tmp_path / "broken.stl"
    broken.write_text("no mesh at all")
    with pytest.raises(FormatError, match="Expected a triangle mesh in '.*broken.stl'"):
        mesh(broken, mass=1)
    unknown = tmp_path / "model.xyzzy"
    unknown.write_text("")
    with pytest.raises(FormatError, match=r"a triangle mesh in '.*model\.xyzzy', but it cannot be read"):
        mesh(unknown, mass=1)


def test_without_trimesh_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(ImportError, match=r"pip install 'freebody\[mesh\]'"):
        mesh("box.stl", mass=1)
