"""The method of a system that makes contacts, and the pairs of shapes it supports."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar
from ..constants import check_default, constant, is_number
from ..description import Description, claim
from ..frame import Frame, Point
from ..shapes.heightline import Heightline
from ..shapes.point import spot
from ..shapes.shape import ContactShape, have_law, may_touch, partners
from .anisotropy import Ellipse, ellipse, is_pair, one_coefficient
from .coefficients import bounce, friction_law, static_law
from .contact import ContactPair
from .normal_law import normal_law

SHAPES = (
    "body.point, body.sphere, body.ellipsoid, body.circle, body.cylinder, body.plane, body.segment, body.corners, "
    "body.box, body.hull, body.capsule, body.drum or body.heightline"
)
IMPACTS = ("newton", "poisson")


def contact(
    system: Description,
    name: str,
    feature: Any,
    surface: Any,
    *,
    friction: Expression = 0,
    static_friction: Expression = None,
    restitution: Expression = 0,
    impact: str = "newton",
    normal: Expression = None,
    along: Any = None,
    adhesion: Expression = 0,
    rolling: Expression = 0,
    spinning: Expression = 0,
) -> ContactPair:
    """Let two shapes touch, with unilateral normal force, Coulomb friction and restitution.

        0 ≤ g ⊥ N ≥ 0,      |T| ≤ μ_s N in stick,      T = -μ_k N γ/|γ| in slip

    with the gap g and the slip velocity γ of the feature over the surface. The normal points from the surface to the
    feature; N and T are the forces on the feature's body.

    Parameters
    ----------
    name : str
        The forces are ``N_name`` and ``T_name`` (in 3-D ``T1_name``, ``T2_name``).
    feature, surface : shapes of two bodies
        From ``body.point, sphere, ellipsoid, circle, segment, corners, box, hull, capsule, drum, plane,
        cylinder, heightline``; the ground has them too. Solids touch each other in families, :meth:`System.contacts`.
        The choice of the feature only sets the sense of the forces.
    friction : expression or two expressions of parameters, optional
        Coefficient of kinetic friction μ_k, which may depend on the slip speed by the name ``slip``, on coordinates,
        speeds and time: ``"mu + (mu_s - mu)*exp(-slip/v)"``. Impacts take its value just before them. In space it may
        be two coefficients, along a direction of the surface and across it: T is in an ellipse, and the friction of a
        slip that with the greatest power.
    static_friction : expression, or two, optional
        μ_s ≥ μ_k; by default μ_k at rest.
    restitution : expression of parameters, optional
        Between 0 and 1.
    impact : "newton" or "poisson"
        Restitution as the ratio of normal speeds (Newton) or of normal impulses (Poisson).
    normal : expression, optional
        Normal force of a compliant contact by its ``depth`` and the ``rate`` of that, such as ``"k*depth**1.5"``
        (Hertz) or ``"k*depth**1.5*(1 + c*rate)"`` (Hunt and Crossley). It only presses. Friction on it is as exact as
        on a rigid contact. By default the contact is rigid.
    along : direction, optional
        Direction of the first of two coefficients of friction, in axes of the surface's body.
    adhesion : expression of parameters, optional
        The pull A [N] that the contact bears while it is closed: N ≥ -A, with friction up to μ (N + A). It does not
        act at a distance, and does not slow a rebound.
    rolling, spinning : expression of parameters, optional
        Lengths [m] whose product with the normal force bounds the moments that resist rolling, about the tangents, and
        spinning, about the normal.

    Raises
    ------
    ModelError
        Shapes of one body or of another system, pairs that are not supported, coefficients out of range.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("disk on a floor")
    >>> disk = s.body("disk", fb.disk(1, 0.3))
    >>> joint = s.planar("plane", s.ground, disk, coordinate="x y turn")
    >>> floor = s.contact("floor", disk.circle(0.3), s.ground.plane(normal="y"), friction=0.2)
    >>> s
    System 'disk on a floor': 1 body, 1 joint, 3 coordinates, 1 contact
    """
    what = f"contact '{name}'"
    claim(system, name, "contact")
    first = shape_of(system, feature, f"the feature of {what}")
    second = shape_of(system, surface, f"the surface of {what}")
    if first.body is second.body:
        raise ModelError(
            f"The feature and the surface of {what} are both on {first.body!r}. A contact is between two bodies, or "
            f"a body and the ground."
        )
    check_pair(first, second, what)
    if not all(have_law(a, b) for a in first.parts(second) for b in second.parts(first)):
        raise ModelError(
            f"The {first.kind} and the {second.kind} of {what} touch in patches, which families of contacts find: "
            f"s.contacts('{name}', [feature], against=surface)."
        )
    kinetic, across, static, direction = coulomb(system, friction, static_friction, along, (second,), what)
    e = bounce(system, restitution, what)
    law_of_impact = impact_law(impact, what)
    law = None if normal is None else compliant(system, normal, (first, second), e, what)
    pull = bearable_pull(system, adhesion, law, what)
    arms = (resisting(system, rolling, "rolling", what), resisting(system, spinning, "spinning", what))
    system.contacts[name] = ContactPair(
        name, first, second, kinetic, static, e, law_of_impact, law, across, direction, pull, *arms
    )
    return system.contacts[name]


def coulomb(
    system: Description, friction: Any, static: Any, along: Any, surfaces: Sequence[ContactShape], what: str
) -> Ellipse:
    """Return the law of friction over surfaces: with one coefficient, or with two along a direction and across it."""
    if is_pair(friction):
        return [ellipse(system, friction, static, along, surface, what) for surface in surfaces][-1]
    one_coefficient(along, what)
    kinetic = friction_law(system, friction, what)
    return Ellipse(kinetic, None, static_law(system, static, kinetic, what), None)


def impact_law(impact: str, what: str) -> str:
    """Return the law of impacts; refuse one that does not exist."""
    if impact not in IMPACTS:
        raise ModelError(f"Expected impact='newton' or impact='poisson' for {what}, got {shown(impact)}.")
    return impact


def resisting(system: Description, length: Expression, about: str, what: str) -> Scalar:
    """Return the length that bounds the moment of resistance; refuse what is not 0 or more."""
    arm = constant(system, length, f"the resistance to {about} of {what}")
    check_default(system, arm, lambda x: x >= 0, f"{about}= of 0 m or more for {what}")
    return arm


def bearable_pull(system: Description, adhesion: Expression, law: Scalar, what: str) -> Scalar:
    """Return the pull that a contact bears; refuse what is not 0 or more, or beside a compliant normal force."""
    pull = constant(system, adhesion, f"the adhesion of {what}")
    check_default(system, pull, lambda x: x >= 0, f"an adhesion of 0 N or more for {what}")
    if law is not None and pull != 0:
        raise ModelError(
            f"{what.capitalize()} has a normal force and an adhesion, which rigid contacts have. A compliant one only "
            f"presses: leave adhesion= or normal= out."
        )
    return pull


def compliant(
    system: Description, normal: Expression, shapes: Sequence[ContactShape], e: Scalar, what: str
) -> Scalar:
    """Return the law of a compliant normal force; refuse what such a contact cannot have."""
    law = normal_law(system, normal, what)
    if e != 0:
        raise ModelError(
            f"{what.capitalize()} has a normal force and a restitution. A compliant contact rebounds by its own law: "
            f'leave restitution= out, and let the force depend on `rate`, as "k*depth**1.5*(1 + c*rate)" does.'
        )
    ended = next((shape for shape in shapes if shape.ended), None)
    if ended is not None:
        raise ModelError(
            f"Expected shapes without ends for {what}, which has a normal force, got a {ended.kind}: where its side "
            f"ends, the depth jumps. Take a plane, a sphere, a circle or points."
        )
    return law


# --- pairs -------------------------------------------------------------------------------------


def check_pair(feature: ContactShape, surface: ContactShape, what: str, cure: str = "") -> None:
    """Refuse two shapes that have no law of contact, or that do not fit into each other."""
    a, b = feature.kind, surface.kind
    if feature.inside:
        raise ModelError(
            f"The feature of {what} is the inside of a {a}. Exchange feature and surface: the hollow is the surface."
        )
    if not (surface.inside or may_touch(type(feature), type(surface))):
        names = partners(type(feature))
        raise ModelError(
            f"The {a} and the {b} of {what} are not a supported pair. {_article(a)} may touch a "
            f"{', '.join(names[:-1]) + ' or ' if len(names) > 1 else ''}{names[-1] if names else 'nothing'}.{cure}"
        )
    for line, other in ((surface, feature), (feature, surface)):
        if isinstance(line, Heightline) and line.kinks and hasattr(other, "radius"):
            raise ModelError(
                f"The heightline {line.height} of {what} has kinks, where a {other.kind} may touch in two places. "
                f"Divide it there, body.heightline(..., between=(start, end)), with a contact for each part."
            )
    parts = feature.parts(surface), surface.parts(feature)
    if surface.inside and not all(have_law(x, y) for x in parts[0] for y in parts[1]):
        raise ModelError(f"The {a} of {what} cannot touch a {b} from inside.")
    R: Any
    r: Any
    R, r = (getattr(shape, "radius", None) for shape in (surface, feature))
    if surface.inside and is_number(R) and is_number(r) and r >= R:
        raise ModelError(f"The {a} of {what} has the radius {r} and does not fit inside a {b} of radius {R}.")


def _article(word: str) -> str:
    return f"{'An' if word[0] in 'aeiou' else 'A'} {word}"


def shape_of(system: Description, shape: Any, what: str) -> ContactShape:
    """Return a shape of the system's own bodies; refuse anything else."""
    if isinstance(shape, Frame):
        raise ModelError(
            f"Expected a shape for {what}, got the whole of {shape!r}. Say what of it touches: {SHAPES}."
        )
    if isinstance(shape, Point):
        shape = spot(shape)
    if not isinstance(shape, ContactShape):
        raise ModelError(f"Expected a shape for {what}, {SHAPES}, got {shown(shape)}.")
    return shape.checked(system, what)
