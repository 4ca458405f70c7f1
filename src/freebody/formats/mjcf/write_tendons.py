"""Fixed tendons of an MJCF file, found among the forces on coordinates of a machine.

Forces c_i F on several coordinates q_i are one force F along the length L = Σ c_i q_i if F depends on the coordinates
by L and on their speeds by L' only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy

from ..machine import Motion


@dataclass
class Pull:
    """Forces on coordinates that are one force F(x, x') along x: a coordinate, or the length of a tendon."""

    part: Any
    force: Any
    weights: list[tuple[Motion, Any]]

    def along(self, x: Any, v: Any, t: Any) -> Any:
        """Return F as a function of x and v = x'."""
        (first, c), *rest = self.weights
        if first.atom is None:
            return self.force
        others = sum((k * motion.atom for motion, k in rest), sympy.Integer(0))
        position, speed = ((y - z) / c for y, z in ((x, others), (v, others.diff(t))))
        force = self.force.subs(first.atom.diff(t), speed).subs(first.atom, position)
        return sympy.expand(force) if rest else force

    @property
    def is_tendon(self) -> bool:
        """True if it acts on several coordinates."""
        return len(self.weights) > 1


def pulls(parts: list[tuple[Any, Motion, Any]], t: Any) -> list[Pull]:
    """Return the forces on coordinates, those that are one force along a length together."""
    groups: dict[Any, list[tuple[Any, Motion, Any, Any]]] = {}
    for part, motion, value in parts:
        content, force = value.as_content_primitive()
        if force.could_extract_minus_sign():
            content, force = -content, -force
        groups.setdefault(force, []).append((part, motion, content, value))
    result = []
    x, v = sympy.symbols("x v", cls=sympy.Dummy)
    for group in groups.values():
        part, _, first, value = group[0]
        own = {motion.name for _, motion, *_ in group}
        pull = Pull(part, value, [(motion, c / first) for _, motion, c, _ in group])
        one = len(group) == len(own) > 1 and not value.is_number
        one = one and not pull.along(x, v, t).has(*(motion.atom for _, motion, *_ in group))
        result += [pull] if one else [Pull(p, y, [(motion, sympy.Integer(1))]) for p, motion, _, y in group]
    return result
