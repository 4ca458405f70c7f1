"""The compiled impact of a problem given by its matrix."""

from types import SimpleNamespace

from cone_problems import contacts_of
from freebody.motion.cones.collision import compiled_code


def impact(A, before, contacts, restitution, law):
    """Impulses, speeds after, energy change, part of the restitution, and residual of a simultaneous impact."""
    it = contacts_of(A, before, contacts, impact=True)
    it.poisson, it.restitution[:] = law == "poisson", restitution
    compiled_code()["collided"](it)
    m = it.rows
    return SimpleNamespace(
        impulses=it.forces[:m].copy(),
        after=it.after[:m].copy(),
        energy=it.energy,
        part=it.part,
        residual=it.residual,
    )
