"""The patches of solids in a run from event to event: features of their points, chosen where they change.

A place of a pair of solids (`model.patched`) has the numbers of a feature: points, normals and directions in the axes
of its bodies. The compiled loop stops where two solids meet and where the features of a patch change
(`families.feature_changes`); here the places get the features of the patch that is there. A feature that stays keeps
its place, and so does a closed crossing between the ends of its edges. The polygon in which two solids touch is
continuous at such a change, so speeds are too.

An open place at the end of its sides, within the distance at which places come, that leaves them does not count: its
contact stays open. Whether it is still a point of the patch is decided by round-off, on one side of a body and not on
the other. One that stands there, as the corners of solids that are stacked flush, counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...describe.shapes.feature import Corner, Edge, Face, Feature
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model.patched import EDGE_ON_EDGE, KINDS
from ..families import feature_changes
from ..families.faces import CORNER, FACE
from ..families.family_record import POSE
from ..families.feature_changes import Followed
from ..families.memory import fill_members, link_poses
from ..families.meshes import most_points
from ..kernels.hoisted import Hoisted
from ..kernels.kernels import Kernels
from ..kernels.program import Program, at_state
from ..ode.dense_output import Array
from ..phase.laws import CLOSED
from ..phase.scene import scene_of

TURNED = 1e-6
"""Sine of the angle from which two normals are different ones."""
SOON, LEAVES = 1e-7, 1e-5
"""Way over which the rate is taken at which a place leaves its sides [m], and the rate from which it leaves them,
relative to the greatest speed."""


class Patches:
    """The patches of one run, and its memory of them."""

    functions_count = 2

    def __init__(self, kernels: Kernels, values: Mapping[str, float]) -> None:
        self.kernels, self.model = kernels, kernels.model
        self.pairs = self.model.patches
        self.solids = self.pairs[0].of
        members = [member.shape for family in self.solids.families for member in family.members]
        starts = np.cumsum([0, *(len(family.members) for family in self.solids.families)])
        points, most = max(map(most_points, members)), max(len(pair.kinds) for pair in self.pairs)
        self.it = Followed.made(members=len(members), pairs=len(self.pairs), points=points)
        it, self.most = self.it, most
        it.families.pairs.most, it.families.patch.most = 1, points
        it.pairs, it.most = len(self.pairs), most
        it.features, it.contact, it.tied = (np.zeros(n * most * len(self.pairs), np.int64) for n in (4, 1, 1))
        self.last = [-np.inf for _ in self.pairs]
        self.left: list[set[tuple[int, ...]]] = [set() for _ in self.pairs]
        it.mode = np.zeros(len(self.model.contacts), np.int64)
        it.first[:], it.second[:] = (
            [getattr(pair, name) + starts[pair.family] for pair in self.pairs] for name in ("first", "second")
        )
        it.used[:] = -1
        self.places: list[dict[int, tuple[int, ...]]] = [{} for _ in self.pairs]
        self.poses, self.name = link_poses(kernels)
        it.poses = self.poses.address(self.name)
        self.machine = scene_of(kernels).candidates.program()  # its outputs begin with q'
        self.functions = feature_changes.functions()
        self.values: dict[str, float] = {}
        self.ready = False
        self.set_values(values)

    def set_values(self, values: Mapping[str, float]) -> None:
        """Go on with other values of the parameters."""
        it, own = self.it, {name for pair in self.pairs for names in pair.names for name in names}
        self.values = {**values, **{name: x for name, x in self.values.items() if name in own}}
        fill_members(it.families, self.solids, {p.name: values[p.name] for p in self.solids.parameters})
        it.families.links.poses = np.zeros(POSE * (1 + len(self.model.links)))
        it.families.links.poses[[0, 4, 8]] = 1
        parameters = self.kernels.parameters(values)
        it.poses_c, self.machine_c = (one.constants(parameters) for one in (self.poses, self.machine))
        state = float_state(self.model, values=self.values)
        self.cores: list[list[Array]] = []
        for p, pair in enumerate(self.pairs):
            shapes = (pair.whole.feature, pair.whole.surface)
            self.cores.append(
                [np.array([[float(state(x)) for x in c] for c in shape.corners]) for shape in shapes]
            )
            it.limit[p] = (
                max(float(np.ptp(core, axis=0).max()) for core in self.cores[p]) / feature_changes.NEAR
            )

    # -- the functions that stop the run ---------------------------------------------------------------

    def with_values(self, values: Program | None, count: int) -> Watching:
        """Return the program of the user's functions, followed by approach and kept."""
        return Watching(self, values, count)

    # -- features --------------------------------------------------------------------------------------

    def look(self, t: float, y: Array) -> None:
        """Set the poses of the links at a state."""
        links = self.it.families.links
        links.poses[POSE:] = at_state(self.poses, self.name, t, y, self.it.poses_c)

    def changed(self, t: float, y: Array) -> bool:
        """Choose the features of the patches whose places do not hold at a state; return True if there are any."""
        self.look(t, y)
        near = CLOSED * (1 + float(np.abs(y[: self.model.n_q + self.model.n_u]).max(initial=0)))
        changed = [self._choose(p, near, t) for p in range(len(self.pairs))]
        self.ready = True
        if any(changed):
            self._let_go(t, y)
        return any(changed)

    def _let_go(self, t: float, y: Array) -> None:
        """Let open places at the ends of their sides count only if they do not leave them."""
        it, n_q = self.it, self.model.n_q
        fastest = 1 + float(np.abs(y[n_q : n_q + self.model.n_u]).max(initial=0))
        later, dt = y.copy(), SOON / fastest
        later[:n_q] += dt * at_state(self.machine, "machine", t, y, self.machine_c)[:n_q]
        for p, (pair, places) in enumerate(zip(self.pairs, self.places, strict=True)):
            at = {place: self.most * p + k for k, place in enumerate(places)}
            open_places = [place for place in places if it.mode[pair.places[place]] == 0]
            now = self._beside(p, t, y, [at[place] for place in open_places])
            edge = {k: d for k, d in zip(open_places, now, strict=True) if d > -self._band(p)}
            then = self._beside(p, t + dt, later, [at[place] for place in edge])
            if edge:
                self._measure(p, t, y)
            for place in open_places:
                self._count(pair, place, True)
            for (place, before), after in zip(edge.items(), then, strict=True):
                self._count(pair, place, after - before <= LEAVES * fastest * dt)

    def _beside(self, p: int, t: float, y: Array, places: Sequence[int]) -> list[float]:
        """Return how far places of a pair lie outside their sides at a state."""
        if not places:
            return []
        self._measure(p, t, y)
        return [float(self.functions["outside"](self.it, at)) for at in places]

    def _measure(self, p: int, t: float, y: Array) -> float:
        """Set the patch of a pair to that at a state; return its gap."""
        self.look(t, y)
        return self._gap(p)

    def _gap(self, p: int) -> float:
        """Set the patch of a pair to that at the poses of the links; return its gap."""
        it = self.it
        return float(
            self.functions["measure"](it.families, it.first[p], it.second[p], 2 * float(it.limit[p]))
        )

    def _band(self, p: int) -> float:
        """Return the distance inside a side from which a place is at its end."""
        return feature_changes.BAND * float(self.it.families.patch.extent)

    def _count(self, pair: Any, place: int, counts: bool) -> None:
        """Let a place count, or not."""
        self.values.update({name: float(counts) for name in pair.names[place] if name.endswith("used")})

    def _choose(self, p: int, near: float, t: float) -> bool:
        it, pair, places = self.it, self.pairs[p], self.places[p]
        if places and self.functions["kept"](it, p):
            return False
        gap = self._gap(p)
        if gap < -feature_changes.SUNK * it.limit[p] and self.ready:
            raise self._sunk(pair, t, -gap)
        patch, round_pair = it.families.patch, it.families.one.radius + it.families.other.radius > 0
        found: list[tuple[int, ...]] = []
        if gap <= near:
            rows = patch.features[: 4 * patch.count].reshape(-1, 4).tolist()
            counts = [self.functions["counts"](it, k) for k in range(len(rows))]
            found = list(dict.fromkeys(tuple(one) for one, good in zip(rows, counts, strict=True) if good))
            if not found and gap < -feature_changes.ROUNDED * it.limit[p]:
                raise self._open_normal(pair, t)
        if found and self.ready and not places and self._several_normals(p):
            raise self._open_normal(pair, t)
        start = self.most * p
        if t != self.last[p]:
            self.left[p].clear()
        tie = t == self.last[p] and not round_pair  # round-off has changed the features back
        if not self.left[p].isdisjoint(found):  # they would go on to change
            it.tied[start : start + len(places)] = feature_changes.ALTERNATES
            if self.functions["kept"](it, p):
                return False
            self._gap(p)
        within = [tie and bool(self.functions["within"](it, start + k)) for k in range(len(places))]
        crosses = [bool(self.functions["crosses"](it, start + k)) for k in range(len(places))]
        marks = {place: feature_changes.CROSSES for place, one in zip(places, crosses, strict=True) if one}
        kept = {
            place: one
            for k, (place, one) in enumerate(places.items())
            if one in found or (found and (within[k] or crosses[k]))
        }
        for one in found:
            if one not in kept.values():
                place = self._place(p, kind_of(one), kept, found)
                kept[place] = one
                normal = patch.points[rows.index(list(one)), 3:6]
                self.values.update(self._numbers(p, place, one, normal))
        for place in places.keys() - kept.keys():
            self._count(pair, place, False)
        it.used[p] = len(kept) or -1
        for k, (place, one) in enumerate(kept.items(), start=start):
            it.features[4 * k : 4 * k + 4], it.contact[k] = one, pair.places[place]
            came_back = tie and one in self.left[p]
            it.tied[k] = marks.get(place, feature_changes.ALTERNATES if came_back else tie)
        self.left[p].update(one for place, one in places.items() if place not in kept)
        self.places[p], self.last[p] = kept, t
        return kept != places

    def _place(self, p: int, kind: int, kept: Mapping[int, Any], found: Sequence[Any]) -> int:
        """Return a place of a kind that is free, or else one whose feature is no point of the patch."""
        kinds = self.pairs[p].kinds
        places = [
            place for place in range(len(kinds)) if kinds[place] == kind and kept.get(place) not in found
        ]
        return min(places, key=lambda place: place in kept)

    def _numbers(self, p: int, place: int, one: tuple[int, ...], normal: Array) -> dict[str, float]:
        """Return the parameters of a place for its features, at a point of the patch with this normal."""
        pair, kind, side = self.pairs[p], self.pairs[p].kinds[place], 1.0
        shapes, features = (pair.whole.feature, pair.whole.surface), (one[:2], one[2:])
        ways = [
            _way(shape, core, feature)
            for shape, core, feature in zip(shapes, self.cores[p], features, strict=True)
        ]
        if kind == EDGE_ON_EDGE:
            poses = [self.it.families.links.poses[POSE * k :] for k in self._links(p)]
            m = np.cross(*(pose[:9].reshape(3, 3) @ way for pose, way in zip(poses, ways, strict=True)))
            side = 1.0 if m @ normal > 0 else -1.0
        numbers: list[float] = []
        for shape, core, feature, way in zip(shapes, self.cores[p], features, ways, strict=True):
            first = shape.faces[feature[0]][0] if feature[1] == FACE else feature[0]
            numbers += [*core[first], 1.0, *way, *([side] if feature[1] >= 0 else [])]
        return dict(zip(pair.names[place], map(float, numbers), strict=True))

    def _several_normals(self, p: int) -> bool:
        """Return True if faces of different directions separate two solids that meet equally well."""
        of, pair = self.it.families, self.pairs[p]
        if of.one.radius + of.other.radius > 0:
            return False
        cores = [np.array(core.corners[: 3 * core.count]).reshape(-1, 3) for core in (of.one, of.other)]
        best: list[tuple[float, Array]] = []
        for k, shape in enumerate((pair.whole.feature, pair.whole.surface)):
            own, other = cores[k], cores[1 - k]
            for face in getattr(shape, "faces", ()):
                n = np.cross(own[face[1]] - own[face[0]], own[face[2]] - own[face[0]])
                n /= np.linalg.norm(n)
                best.append((float((other @ n).min() - own[face[0]] @ n), n if k == 0 else -n))
        most = max(apart for apart, _ in best)
        ways = [n for apart, n in best if apart > most - feature_changes.ROUNDED * self.it.limit[p]]
        return any(np.linalg.norm(np.cross(ways[0], n)) > TURNED for n in ways)

    def _open_normal(self, pair: Any, t: float) -> SimulationError:
        """Return the error for two edges that are parallel."""
        return SimulationError(
            f"Edges of '{pair.whole.name}' that are parallel, or an edge and a corner, meet at t = {t:.9g} s, and the "
            "direction of their force is open: rigid bodies do not decide what happens there. Turn one of them a "
            'little at the start, or take method="timestepping" with step=.'
        )

    def _sunk(self, pair: Any, t: float, depth: float) -> SimulationError:
        """Return the error for solids that sink into each other."""
        return SimulationError(
            f"The solids of '{pair.whole.name}' are {depth:.3g} m in each other at t = {t:.9g} s: a place where they "
            "touch was passed over, as may happen where an edge lies almost flat on a face. Change the start a little, "
            'or take method="timestepping" with step=.'
        )

    def _links(self, p: int) -> list[int]:
        """Return the links of the members of a pair, the ground is 0."""
        link = self.it.families.members.link
        return [int(link[k]) for k in (self.it.first[p], self.it.second[p])]


def kind_of(one: tuple[int, ...]) -> int:
    """Return the kind of a place with these features."""
    return KINDS.index((_kind(one[1]), _kind(one[3])))


def _kind(mark: int) -> type[Feature]:
    """Return the kind of a feature by its second number."""
    return {CORNER: Corner, FACE: Face}.get(mark, Edge)


def _way(shape: Any, corners: Array, feature: tuple[int, ...]) -> Array:
    """Return the normal of a face of a solid or the direction of an edge; nothing of a corner."""
    k, mark = feature
    if mark == CORNER:
        return np.zeros(0)
    if mark == FACE:
        p, q, r = (corners[i] for i in shape.faces[k][:3])
        way = np.cross(q - p, r - p)
    else:
        way = corners[mark] - corners[k]
    return way / np.linalg.norm(way)


class Watching:
    """The program of the functions of the user, then approach and kept of the patches of a run.

    Its constant is the address of the record of the patches.
    """

    hoisted = 1

    def __init__(self, patches: Patches, own: Program | None, count: int) -> None:
        self.patches, self.own = patches, own
        patches.it.asked = count
        if own is not None:
            patches.it.values = own.address("values")

    @property
    def compiled(self) -> Watching:
        """The program itself, which has a number of constants as compiled ones have."""
        return self

    @property
    def parameters(self) -> int:
        """Number of parameters."""
        return 0 if self.own is None else int(self.own.compiled.parameters)

    def address(self, name: str) -> int:
        """Address of the kernel."""
        return int(self.patches.functions[name].address)

    def follow(self, hoisted: Hoisted, constants: Array) -> None:
        """Let the constants of the functions of the user follow the parameters that a run writes."""
        if self.own is not None:
            self.own.follow(hoisted, self.patches.it.values_c)

    def constants(self, parameters: Array) -> Array:
        """Return its constant; those of the functions of the user are written into the record."""
        it = self.patches.it
        if self.own is not None:
            it.values_c = self.own.constants(parameters)
        return np.array([it.address]).view(float)
