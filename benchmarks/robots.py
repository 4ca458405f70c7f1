"""(j) Robots: every URDF file that the installed packages bring, read and compared with Pinocchio, and every MJCF file
with MuJoCo (:mod:`benchmarks.mujoco_peer`).

A file is read with numbers for all masses and lengths. At random states, mass matrix M and bias forces h are compared
relative to their largest entries. Joints that mimic others follow by the rates G of all joints: Gᵀ M G and Gᵀ h.
Forward dynamics a is compared by the residual M a + h of Pinocchio's M and h, relative to |M| |a| + |h|, which does
not depend on the condition of M. Pinocchio has no dampers and springs: what ours do is added to its h.

Each robot of a URDF file is drawn with its meshes, and falls for a second on a page.

The files come with packages such as example-robot-data (``pip install '.[robots]'``); none is part of this repository.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np

from .tables import NOT_INSTALLED, module, show, time_text

STATES = 3
LENGTH = 1
"""Length of the motion on a page [s]."""
CLOSE = 1e-12
"""Difference beyond which a file is compared with the angles that are written."""
SHOWN = 12
"""Number of files in the table of pages: the largest."""


def files() -> list[Path]:
    """Return every URDF file beside the installed packages."""
    found: set[Path] = set()
    for folder in map(Path, sys.path):
        if folder.name in ("site-packages", "dist-packages"):
            found.update(folder.rglob("*.urdf"))
    return sorted(found)


class Peer:
    """A robot in Pinocchio, fixed at its first link or free."""

    def __init__(self, path: Path, base: str) -> None:
        import pinocchio

        self.pin = pinocchio
        first = [pinocchio.JointModelFreeFlyer()] if base == "free" else []
        self.model = pinocchio.buildModelFromUrdf(str(path), *first)
        self.data = self.model.createData()

    def differences(self, system: Any, random: Any) -> tuple[float, float, float]:
        """Return the differences of M, h and a at a random state."""
        import freebody as fb

        program = fb.compile(system)
        q, u, place, rates, G, h = self.state(system, fb.assemble(system), random)
        M = self.pin.crba(self.model, self.data, place)
        M = G.T @ (np.triu(M) + np.triu(M, 1).T) @ G
        h = h + G.T @ self.pin.rnea(self.model, self.data, place, rates, np.zeros(self.model.nv))
        a = program.forward_dynamics(q, u)
        most = float(np.abs(M).max())
        rest = np.abs(M @ a + h).max() / (most * np.abs(a).max() + np.abs(h).max() or 1)
        return (
            float(np.abs(program.mass_matrix(q) - M).max() / most),
            float(np.abs(program.bias(q, u) - h).max() / (np.abs(h).max() or 1)),
            float(rest),
        )

    def state(self, system: Any, model: Any, random: Any) -> tuple[Any, ...]:
        """Return our q and u, Pinocchio's, the rates G of its speeds to ours, and the forces of dampers and springs."""
        values = {name: random.uniform(-1, 1) for name in (*model.coordinate_names, *model.speed_names)}
        for joint in system.joints.values():
            if joint.type in ("free", "ball"):
                names = [str(atom.func) for atom in joint.primitives[0].coordinate][-4:]
                length = float(np.linalg.norm([values[name] for name in names]))
                values |= {name: values[name] / length for name in names}
        speeds = list(model.speed_names)
        place, rates = self.pin.neutral(self.model), np.zeros(self.model.nv)
        G, h = np.zeros((self.model.nv, len(speeds))), np.zeros(len(speeds))
        for number, name in enumerate(self.model.names):
            own = system.joints.get("base" if name == "root_joint" else system.reading.names.get(name, name))
            if number == 0 or own is None:
                continue
            theirs = self.model.joints[number]
            at, where = theirs.idx_q, theirs.idx_v
            if own.type == "free":
                prefix = str(own.primitives[0].coordinate[0].func)[:-2]
                order = [f"{prefix}_{x}" for x in ("x", "y", "z", "e1", "e2", "e3", "e0")]
                place[at : at + 7] = [values[name] for name in order]
                for i, x in enumerate(("vx", "vy", "vz", "wx", "wy", "wz")):
                    G[where + i, speeds.index(f"{prefix}_{x}")] = 1
                continue
            displacement = own.primitives[0].coordinate
            x = float(displacement.subs({atom: values[str(atom.func)] for atom in coordinates(displacement)}))
            for atom in coordinates(displacement):
                G[where, speeds.index(f"{atom.func}'")] = float(displacement.diff(atom))
            place[at : at + theirs.nq] = (np.cos(x), np.sin(x)) if theirs.nq == 2 else (x,)
            force = 0.0
            rate = float(G[where] @ [values[speed] for speed in speeds])
            for load in system.loads.values():
                if getattr(load, "joint", None) is own:
                    force += float(getattr(load, "damping", 0)) * rate
                    if hasattr(load, "stiffness"):
                        force += float(load.stiffness) * (x - float(load.rest))
            h += G[where] * force
        u = np.array([values[speed] for speed in speeds])
        rates[:] = G @ u
        return np.array([values[name] for name in model.coordinate_names]), u, place, rates, G, h


def coordinates(expression: Any) -> list[Any]:
    """Return the coordinates in an expression."""
    import sympy

    return sorted(expression.atoms(sympy.core.function.AppliedUndef), key=str)


def compared(path: Path, base: str) -> tuple[str, Any]:
    """Return what became of a file, and the differences to Pinocchio or a reason."""
    import freebody as fb
    from freebody.errors import FreebodyError

    try:
        system = fb.read(path, base=base, symbols="none", meshes=False)
    except FreebodyError as error:
        return "refused", str(error)
    if not system.joints:
        return "no joint moves", None
    try:
        peer = Peer(path, base)
    except ValueError as error:
        return "Pinocchio refuses", str(error)
    random = np.random.default_rng(1)
    try:
        found = [peer.differences(system, random) for _ in range(STATES)]
    except FreebodyError as error:
        return "no motion", str(error)
    return "compared", np.max(found, axis=0)


class Pictures(NamedTuple):
    """Processor time of reading, of the drawing, of the motion and of the page [s], with their sizes [bytes]."""

    read: float
    drawing: float
    drawing_size: int
    motion: float
    page: float
    page_size: int


def pictures(path: Path, folder: Path) -> Pictures | str:
    """Return how long a robot's drawing and page take, which are written into a folder; or what was refused.

    A robot of which nothing moves on the ground is free. Where a motion ends in a singular position, its page has the
    motion up to there.
    """
    import freebody as fb
    from freebody.errors import FreebodyError, SimulationError

    now, clock = time.process_time, [time.process_time()]
    try:
        system = fb.read(path, symbols="none")
        if not system.bodies:
            system = fb.read(path, symbols="none", base="free")
        clock.append(now())
        drawing = folder / f"{path.stem}.svg"
        fb.draw(system).save(drawing)
        clock.append(now())
        try:
            motion = fb.simulate(system, LENGTH)
        except SimulationError as error:
            if (motion := error.trajectory) is None:
                raise
        clock.append(now())
        page = fb.report(system, motion, folder / f"{path.stem}.html")
    except FreebodyError as error:
        return str(error)
    clock.append(now())
    read, drawn, moved, paged = np.diff(clock).tolist()
    return Pictures(read, drawn, drawing.stat().st_size, moved, paged, page.stat().st_size)


def table_of_pictures(paths: list[Path]) -> None:
    """Print drawings and pages: the largest, and all messages."""
    found: dict[Path, Pictures | str] = {}
    for path in paths:
        with tempfile.TemporaryDirectory() as folder:
            found[path] = pictures(path, Path(folder))
    good = [(path, one) for path, one in found.items() if isinstance(one, Pictures)]
    if not good:
        return
    good.sort(key=lambda row: -row[1].page_size)
    show(
        f"Drawings and pages of {len(good)} URDF files, {LENGTH} s of falling",
        ["file", "read", "drawing", "", "motion", "page", ""],
        [
            [path.name, time_text(one.read), time_text(one.drawing), f"{one.drawing_size / 1000:.0f} kB",
             time_text(one.motion), time_text(one.page), f"{one.page_size / 10**6:.1f} MB"]
            for path, one in good[:SHOWN]
        ],
        [
            "Longest: " + ", ".join(
                f"{name} {time_text(getattr(one, name))} ({path.name})"
                for name in ("read", "drawing", "motion", "page")
                for path, one in [max(good, key=lambda row: getattr(row[1], name))]
            )
        ]
        + [f"{path.name}: {one}" for path, one in found.items() if isinstance(one, str)],
    )  # fmt: skip


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table of pictures, that of MJCF, and that of URDF with each base."""
    del repeats, limit
    chosen = files()[:: 10 if quick else 1]
    table_of_pictures(chosen)
    if module("mujoco") is None:
        print(f"robots: MuJoCo is {NOT_INSTALLED}")
    else:
        from .mujoco_peer import table

        table(quick)
    if module("pinocchio") is None:
        print(f"robots: Pinocchio is {NOT_INSTALLED}")
        return
    for base in ("fixed", "free"):
        outcomes: dict[str, list[tuple[Path, Any]]] = {}
        begin, written = time.perf_counter(), []
        for path in chosen:
            outcome, found = compared(path, base)
            outcomes.setdefault(outcome, []).append((path, found))
            if outcome == "compared" and max(found) > CLOSE:
                with mock.patch("freebody.formats.urdf.origin.DECIMALS", 100):
                    written.append(max(compared(path, base)[1]))
        rows = sorted(outcomes.get("compared", []), key=lambda row: -max(row[1]))
        counts = ", ".join(f"{len(rows)} {outcome}" for outcome, rows in sorted(outcomes.items()))
        show(
            f"URDF files, base {base}: {counts}",
            ["file", "M", "bias", "forward dynamics"],
            [[path.name, *(f"{x:.0e}" for x in found)] for path, found in rows],
            [
                f"Largest differences of {len(rows)} files; all in {time_text(time.perf_counter() - begin)}. With the "
                f"angles that are written, the {len(written)} files beyond {CLOSE:.0e} differ by "
                f"{max(written, default=0):.0e}."
            ]
            + [
                f"{outcome}: {path.name}" + (f": {found}" if found else "")
                for outcome, rows in sorted(outcomes.items())
                if outcome != "compared"
                for path, found in rows
            ],
        )
