"""(j) MJCF: every file that the installed packages bring and that MuJoCo compiles, read and compared with MuJoCo.

Both model the same: contacts, limits, dry friction, fluid and gravity compensation are switched off in MuJoCo, and
equalities in both (:func:`tree_of`). At random states, mass matrix M, bias forces h (with springs, dampers, tendons and
actuators at random controls), forward dynamics a and the poses of all bodies are compared: M and h relative to their
largest entries, a by the residual M a + h of MuJoCo's M and h, relative to |M| |a| + |h|, which does not depend on the
condition of M, and poses relative to the size of the machine.

Where they differ by more than `CLOSE`, MuJoCo gets freebody's inertias in exact principal axes, and is compared again.
What else MuJoCo has and freebody does not read must stand in the report of the file.
"""

from __future__ import annotations

import sys
import time
import xml.etree.ElementTree as tree
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .tables import show, time_text

STATES = 3
FREE, BALL = 0, 1  # types of joints in MuJoCo
CLOSE = 1e-12
"""Difference beyond which it is asked whether it comes from MuJoCo's principal axes of inertia."""
LARGEST = 150
"""Greatest number of speeds of a model that is compared."""


def files() -> list[Path]:
    """Return every XML file beside the installed packages with the root of MJCF."""
    found: set[Path] = set()
    for folder in map(Path, sys.path):
        if folder.name in ("site-packages", "dist-packages"):
            found.update(path for path in folder.rglob("*.xml") if b"<mujoco" in path.read_bytes()[:20000])
    return sorted(path for path in found if b"<mujocoinclude" not in path.read_bytes()[:20000])


def tree_of(system: Any) -> Any:
    """Return the system without what closes loops or constrains it."""
    system.constraints.clear()
    for name in [name for name, joint in system.joints.items() if joint.closes]:
        del system.joints[name]
    return system


class Found(NamedTuple):
    """Differences of M, h, a and poses, what the report does not say, and beyond `CLOSE` where the difference is from.

    That is the largest product of inertia in MuJoCo's principal axes, of the largest moment, and the largest difference
    with freebody's inertias in MuJoCo.
    """

    differences: np.ndarray
    unsaid: list[str]
    product: float = 0.0
    explained: float = 0.0


class Peer:
    """A model in MuJoCo, without what freebody does not model."""

    def __init__(self, path: Path) -> None:
        import mujoco

        self.mujoco = mujoco
        mujoco.set_mju_user_warning(lambda text: None)
        self.model = m = mujoco.MjModel.from_xml_path(str(path))
        flag = mujoco.mjtDisableBit
        m.opt.disableflags |= flag.mjDSBL_CONTACT | flag.mjDSBL_CONSTRAINT
        m.opt.density = m.opt.viscosity = 0
        m.body_gravcomp[:] = 0
        self.data = mujoco.MjData(m)

    def only(self, system: Any) -> None:
        """Switch off what freebody did not read: spatial tendons, actuators."""
        m = self.model
        notes = [note.element for note in system.reading.notes if note.what.startswith("springdamper")]
        for j in range(m.njnt):
            if f"joint '{m.joint(j).name}'" in notes:
                m.jnt_stiffness[j] = m.dof_damping[m.jnt_dofadr[j]] = 0
        for i in range(m.ntendon):
            if int(m.wrap_type[m.tendon_adr[i]]) != int(self.mujoco.mjtWrap.mjWRAP_JOINT):
                m.tendon_stiffness[i] = m.tendon_damping[i] = 0

    def differences(self, system: Any, random: Any) -> tuple[float, ...]:
        """Return the differences of M, h, a and poses at a random state."""
        import freebody as fb

        program, model = fb.compile(system), fb.assemble(system)
        m, d = self.model, self.data
        values = self.state(system, random)
        inputs = system.reading.inputs
        for i in range(m.nu):
            d.ctrl[i] = random.uniform(-1, 1)
            name = m.actuator(i).name
            parameter = inputs.get(name) or inputs.get(f"actuator{i + 1}")
            if parameter is None:
                m.actuator_gainprm[i] = m.actuator_biasprm[i] = 0
            else:
                values[parameter] = d.ctrl[i]
        q = np.array([values[name] for name in model.coordinate_names])
        u = np.array([values[name] for name in model.speed_names])
        given = {name: values[name] for name in inputs.values()}
        self.mujoco.mj_forward(m, d)
        M, h, S = (
            np.zeros((m.nv, m.nv)),
            d.qfrc_bias - d.qfrc_passive - d.qfrc_actuator,
            self.speeds(model, values),
        )
        self.mujoco.mj_fullM(m, d, M)
        M, h = S.T @ M @ S, S.T @ (h + M @ self.drift)
        a = program.forward_dynamics(q, u, values=given)
        most = float(np.abs(M).max())
        rest = np.abs(M @ a + h).max() / (most * np.abs(a).max() + np.abs(h).max() or 1)
        return (
            float(np.abs(program.mass_matrix(q, values=given) - M).max() / most),
            float(np.abs(program.bias(q, u, values=given) - h).max() / (np.abs(h).max() or 1)),
            float(rest),
            self.poses(system, program, q, given),
        )

    def unsaid(self, system: Any) -> list[str]:
        """Return what the model has beside what is compared and the report does not say."""
        m = self.model
        said = "\n".join(f"{note.what}: {note.element} {note.detail}" for note in system.reading.notes)
        spatial = [
            i
            for i in range(m.ntendon)
            if int(m.wrap_type[m.tendon_adr[i]]) != int(self.mujoco.mjtWrap.mjWRAP_JOINT)
        ]
        there = {
            "weight acts in full": m.body_gravcomp.any(),
            "no fluid acts": m.opt.density or m.opt.viscosity,
            "limits=True": m.jnt_limited.any()
            or any(m.tendon_limited[i] for i in range(m.ntendon) if i not in spatial),
            "friction=True": m.dof_frictionloss[m.jnt_dofadr[m.jnt_type != FREE]].any(),
            "nothing touches": m.ngeom > 1 and (m.geom_contype.any() or m.geom_conaffinity.any()),
            "spatial tendon": spatial,
            "sensors": m.nsensor,
        }
        result = [text for text, is_there in there.items() if is_there and text not in said]
        inputs = system.reading.inputs
        for i in range(m.nu):
            name = m.actuator(i).name or f"actuator{i + 1}"
            if name not in inputs and f"'{name}'" not in said:
                result.append(f"actuator '{name}'")
        return result

    def with_inertias_of(self, system: Any) -> float:
        """Take freebody's inertias; return their largest product in MuJoCo's principal axes, of the largest moment."""
        m, taken, worst = self.model, set(), 0.0
        names = [m.body(i).name or f"body{i}" for i in range(m.nbody)]
        on = [
            system.reading.frames[name] if i else (system.ground.origin, np.eye(3))
            for i, name in enumerate(names)
        ]
        alone = Counter(point.body.name for point, _ in on)
        for i, (point, axes) in enumerate(on):
            if point.body.is_ground:
                continue
            m.body_inertia[i], own = 0, point.body.mass_properties
            R, theirs = np.array(axes, float), np.zeros(9)
            self.mujoco.mju_quat2Mat(theirs, m.body_iquat[i])
            m.body_mass[i] = 0
            if point.body.name in taken:
                continue
            taken.add(point.body.name)
            J = R.T @ np.array(own.inertia, float) @ R
            m.body_mass[i] = float(own.mass)
            m.body_ipos[i] = R.T @ (np.array(own.center, float) - np.array(point.components, float))
            turned = theirs.reshape(3, 3).T @ J @ theirs.reshape(3, 3)
            if alone[point.body.name] == 1 and J.any():
                products = np.abs(turned - np.diag(np.diag(turned))).max()
                worst = max(worst, float(products / np.abs(turned).max()))
            m.body_inertia[i], principal = np.linalg.eigh(J)
            if np.linalg.det(principal) < 0:
                principal[:, 0] *= -1
            self.mujoco.mju_mat2Quat(m.body_iquat[i], principal.ravel())
        self.mujoco.mj_setConst(m, self.data)
        return worst

    def state(self, system: Any, random: Any) -> dict[str, float]:
        """Set a random state, and return our values of it."""
        m, d = self.model, self.data
        d.qpos[:], d.qvel[:] = random.uniform(-1, 1, m.nq), random.uniform(-1, 1, m.nv)
        values: dict[str, float] = {}
        self.names = list(system.reading.coordinates.values())
        assert len(self.names) == m.njnt, (len(self.names), m.njnt)
        for j, names in enumerate(self.names):
            at, where, kind = m.jnt_qposadr[j], m.jnt_dofadr[j], int(m.jnt_type[j])
            if kind in (FREE, BALL):
                end = at + (7 if kind == FREE else 4)
                d.qpos[end - 4 : end] /= np.linalg.norm(d.qpos[end - 4 : end])
                prefix = names[-1][:-3]
                turns = where + (3 if kind == FREE else 0)
                values |= {f"{prefix}_w{x}": d.qvel[turns + i] for i, x in enumerate("xyz")}
                if kind == FREE:
                    R = np.zeros(9)
                    self.mujoco.mju_quat2Mat(R, d.qpos[end - 4 : end])
                    slides = R.reshape(3, 3).T @ d.qvel[where : where + 3]
                    values |= {f"{prefix}_v{x}": slides[i] for i, x in enumerate("xyz")}
            else:
                values[f"{names[0]}'"] = d.qvel[where]
            values |= {name: d.qpos[at + i] for i, name in enumerate(names)}
        return values

    def speeds(self, model: Any, values: dict[str, float]) -> np.ndarray:
        """Return the rates S of MuJoCo's speeds to ours; ``drift`` is what is left of their accelerations."""
        m, d = self.model, self.data
        S, names = np.zeros((m.nv, len(model.speed_names))), list(model.speed_names)
        self.drift = np.zeros(m.nv)
        for j, own in enumerate(self.names):
            where, kind, at = m.jnt_dofadr[j], int(m.jnt_type[j]), m.jnt_qposadr[j]
            if kind not in (FREE, BALL):
                S[where, names.index(f"{own[0]}'")] = 1
                continue
            prefix = own[-1][:-3]
            turns = where
            if kind == FREE:
                R = np.zeros(9)
                self.mujoco.mju_quat2Mat(R, d.qpos[at + 3 : at + 7])
                R = R.reshape(3, 3)
                columns = [names.index(f"{prefix}_v{x}") for x in "xyz"]
                S[where : where + 3, columns] = R
                turns = where + 3
                w, v = ([values[f"{prefix}_{c}{x}"] for x in "xyz"] for c in "wv")
                self.drift[where : where + 3] = R @ np.cross(w, v)  # d(R v)/dt = R (v' + w x v)
            S[turns : turns + 3, [names.index(f"{prefix}_w{x}") for x in "xyz"]] = np.eye(3)
        return S

    def poses(self, system: Any, program: Any, q: np.ndarray, given: dict[str, float]) -> float:
        """Return the largest difference of the place and axes of a body."""
        m, d = self.model, self.data
        own = program.poses(q, values=given)
        size = max(1.0, float(np.abs(d.xpos).max()))
        worst = 0.0
        for i in range(1, m.nbody):
            name = m.body(i).name or f"body{i}"
            point, axes = system.reading.frames[name]
            R, p = (np.eye(3), np.zeros(3)) if point.body.name == "ground" else own[point.body.name]
            p = p + R @ np.array(point.components, float)
            R = R @ np.array(axes, float)
            worst = max(
                worst, float(np.abs(p - d.xpos[i]).max()) / size, float(np.abs(R.ravel() - d.xmat[i]).max())
            )
        return worst


def of_urdf(path: Path, system: Any, random: Any) -> tuple[float, float, float]:
    """Return the differences of M, h and a of a URDF file of hinges and slides at a random state.

    MuJoCo reads the file without its solids, and joints that mimic others as joints of their own: these follow by the
    rates G of all joints, GᵀMG and Gᵀh.
    """
    import mujoco

    import freebody as fb

    root = tree.parse(path).getroot()
    for link in root.iter("link"):
        for tag in ("visual", "collision"):
            for solid in link.findall(tag):
                link.remove(solid)
    m = mujoco.MjModel.from_xml_string(tree.tostring(root, "unicode"))
    m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    d, program, model = mujoco.MjData(m), fb.compile(system), fb.assemble(system)
    symbols = {one.symbol: i for i, one in enumerate(model.coordinates)}
    q, u = (random.uniform(-1, 1, model.n_u) for _ in range(2))
    G = np.zeros((m.nv, model.n_u))
    for j in range(m.njnt):
        name = m.joint(j).name
        y = system.joints[system.reading.names.get(name, name)].primitives[0].coordinate
        atoms = [atom for atom in symbols if y.has(atom)]
        d.qpos[m.jnt_qposadr[j]] = y.subs({atom: q[symbols[atom]] for atom in atoms})
        for atom in atoms:
            G[m.jnt_dofadr[j], symbols[atom]] = y.diff(atom)
    d.qvel[:] = G @ u
    mujoco.mj_forward(m, d)
    M = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, M)
    M, h, a = G.T @ M @ G, G.T @ (d.qfrc_bias - d.qfrc_passive), program.forward_dynamics(q, u)
    most = float(np.abs(M).max())
    return (
        float(np.abs(program.mass_matrix(q) - M).max() / most),
        float(np.abs(program.bias(q, u) - h).max() / (np.abs(h).max() or 1)),
        float(np.abs(M @ a + h).max() / (most * np.abs(a).max() + np.abs(h).max() or 1)),
    )


def compared(path: Path) -> tuple[str, Any]:
    """Return what became of a file, and what was found of it (`Found`) or a reason."""
    import freebody as fb
    from freebody.errors import FreebodyError

    try:
        peer = Peer(path)
    except (ValueError, AttributeError) as error:
        return "MuJoCo refuses", str(error)
    if not 0 < peer.model.nv <= LARGEST:
        return "no joint moves" if not peer.model.nv else "large", peer.model.nv
    try:
        system = tree_of(fb.read(path, symbols="none", meshes=False))
    except FreebodyError as error:
        return "refused", str(error)
    unsaid = peer.unsaid(system)
    peer.only(system)

    def worst() -> np.ndarray:
        random = np.random.default_rng(1)
        return np.max([peer.differences(system, random) for _ in range(STATES)], axis=0)

    try:
        differences = worst()
        if max(differences) <= CLOSE:
            return "compared", Found(differences, unsaid)
        product = peer.with_inertias_of(system)
        return "compared", Found(differences, unsaid, product, max(worst()))
    except FreebodyError as error:
        return "no motion", str(error)


def table(quick: bool = False) -> None:
    """Print what became of every file."""
    begin = time.perf_counter()
    outcomes: dict[str, list[tuple[Path, Any]]] = {}
    for path in files()[:: 10 if quick else 1]:
        outcome, found = compared(path)
        outcomes.setdefault(outcome, []).append((path, found))
    rows = sorted(outcomes.get("compared", []), key=lambda row: -max(row[1].differences))
    counts = ", ".join(f"{len(rows)} {outcome}" for outcome, rows in sorted(outcomes.items()))
    others = [
        f"{outcome}: {path.name}" + (f": {found}" if found else "")
        for outcome, rows in sorted(outcomes.items())
        if outcome != "compared"
        for path, found in rows
    ]
    show(
        f"MJCF files: {counts}",
        ["file", "M", "bias", "forward dynamics", "poses"],
        [[path.name, *(f"{x:.0e}" for x in found.differences)] for path, found in rows],
        [
            *(
                f"{path.name}: inertias have products of {found.product:.0e} in MuJoCo's principal axes; with "
                f"freebody's inertias in MuJoCo the largest difference is {found.explained:.0e}."
                for path, found in rows
                if found.explained
            ),
            *(
                f"{path.name}: not in the report: {', '.join(found.unsaid)}"
                for path, found in rows
                if found.unsaid
            ),
            f"{sum(not found.unsaid for _, found in rows)} of {len(rows)} reports say all that MuJoCo has besides.",
            f"Largest differences of {len(rows)} files; all in {time_text(time.perf_counter() - begin)}.",
            *others,
        ],
    )
