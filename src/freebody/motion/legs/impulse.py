"""``fb.impulse``: effect of a blow, or of an impact with given restitution, on a machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from ...describe.body import Body
from ...describe.frame import Point
from ...describe.system import System
from ...dynamics.conditions.constrained import independent_rows
from ...dynamics.kinematics import place_of, point_velocity, rotation
from ...dynamics.state import State, state_at
from ...errors import ModelError, arguments_named, nearest
from ...model.assemble import assemble
from ...model.model import Model
from ...model.values import check_assumptions
from ...scalar.algebra import ZERO, Expression, Matrix, Vector, apply, dot
from ...space.rotation import Rotation
from ...symbolic.derivation.bodies import own_body
from ...symbolic.derivation.contact_modes import check_modes_are_chosen
from ...symbolic.equations import Equations
from ...symbolic.impulses.impulse import Struck
from ...symbolic.impulses.impulse_jumps import Jumps, exact_jumps, float_jumps, percussion, restituted
from ...symbolic.solving.vocabulary import Vocabulary
from ..kernels.kernels import kernels_of
from ..start.initial import initial_state, number, quaternions_by_joint
from ..start.loop_closure import closed_start


@arguments_named
def impulse(
    s: Any,
    *,
    at: Any = None,
    impulse: Vector | None = None,
    moment: Vector | None = None,
    frame: Any = None,
    normal: Vector | None = None,
    restitution: Expression | None = None,
    initial: Any = None,
    values: Mapping[Any, Any] | None = None,
    t: Expression | None = None,
    near: Mapping[Any, Any] | None = None,
) -> Struck:
    """Return the speeds just after an impulse, and the impulsive reactions of all joints.

        M Δu = Jᵀ P + Gᵀ Λ,    G Δu = 0

    Parameters
    ----------
    s : System, Model or Equations
    at : Point or Body
        Point at which the impulse acts; for a body, its origin.
    impulse : three numbers or expressions, optional
        Components of the impulse [N s].
    moment : three numbers or expressions, optional
        Additional moment impulse on the same body [N m s].
    frame : Body, optional
        Body in whose axes the components are; ground axes if not given.
    normal, restitution : three components and a number, optional
        In place of an impulse: the point hits a smooth surface fixed in the ground, whose normal points to the body,
        n·v⁺ = -e n·v⁻ (Newton).
    initial : mapping, or Trajectory, optional
        State just before, as for :func:`simulate`; a trajectory stands for its last state, with its values. Without
        ``values``, coordinates and speeds not named stay symbols.
    values : mapping, optional
        Values of parameters in place of their defaults. If given, even empty, all is computed with numbers; otherwise
        the result is exact.
    t : number, optional
        Time, for driven machines [s].
    near : mapping, optional
        Guesses of coordinates that close loops, as for :func:`simulate`.

    Returns
    -------
    Struck
        ``.after`` (speeds by name), ``.reactions``, ``.energy_change``, ``.initial`` (for the next ``simulate``),
        ``.solve("pin_x = 0", for_="h")``.

    Raises
    ------
    ModelError
        A point of another system, no impulse, an impossible impact, an incomplete or wrong initial state.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("hanging bar")
    >>> m, L, J, h = s.parameters(m=2, L=1.2, J=1, h=0.8)
    >>> bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> hit = fb.impulse(s, at=bar.point(0, L/2 - h, 0), impulse=(J, 0, 0), initial={"theta": 0, "theta'": 0})
    >>> hit
    Impulse on 'hanging bar': speeds just after
      theta' = 3*J*h/(m*L^2)
    impulsive reactions on the child bodies
      pin_x = (3*h/(2*L) - 1)*J
    >>> hit.solve("pin_x = 0", for_="h")
    h = 2*L/3
    """
    e = _equations(s, "fb.impulse")
    model = e.model
    trajectory = initial if hasattr(initial, "path") and hasattr(initial, "at") else None
    if trajectory is not None:
        t = float(trajectory.path.times[-1]) if t is None else t
        initial = trajectory.at(t)
        values = trajectory.values | dict(values or {})
    if values is None:
        state = _exact_state(e, initial or {}, t)
        jumps = exact_jumps(e, state)
    else:
        numbers = model.values(values)
        check_assumptions(model, numbers)
        begin = 0.0 if t is None else number(model, numbers, t, "t")
        if model.constraints:
            y, active = closed_start(kernels_of(model), numbers, initial or {}, near or {}, begin, False)
        else:
            y, active = initial_state(model, numbers, initial or {}), ()
        state = state_at(model, y, begin, values)
        jumps = float_jumps(model, state, active or independent_rows(model, state))
    options = dict(at=at, impulse=impulse, moment=moment, frame=frame, normal=normal, restitution=restitution)
    return Struck(e, state, jumps, [acting_blow(model, state, jumps, options, values is None)])


def acting_blow(
    model: Model, state: State, jumps: Jumps, options: Mapping[str, Any], exact: bool = False
) -> tuple[Point, Vector, Vector]:
    """Return the point of a blow, its impulse and its moment impulse in ground axes [N s, N m s]; options are arguments
    of :func:`impulse`. That of a surface changes the speeds of the state, as the ``jumps`` of the speeds say.

    Raises
    ------
    ModelError
        A point of another system, no impulse, an impossible impact.
    """
    keys = ("impulse", "normal", "restitution", "moment", "frame")
    impulse, normal, restitution, moment, frame = (options[key] for key in keys)
    if normal is None and restitution is None:
        return resolved_blow(model, state, options["at"], impulse, moment, frame)
    if impulse is not None or normal is None or restitution is None:
        raise ModelError(
            "Expected either impulse=, or normal= and restitution= together, from which the impulse follows."
        )
    direction = _vector(state, normal, _axes(model, state, frame), "the normal")
    if all(c == 0 for c in direction):
        raise ModelError(f"Expected a direction for the normal, got {normal!r}.")
    e_N = state(model.names.expression(restitution, "the coefficient of restitution"))
    point, _, n = resolved_blow(model, state, options["at"], ZERO, moment, frame)
    return point, restituted(model, state, jumps, point, direction, e_N, exact), n


def approach_to_surface(model: Model, state: State, options: Mapping[str, Any]) -> float:
    """Return the speed, times |normal|, with which the point of a blow approaches the surface that it meets [m/s]."""
    normal = _vector(state, options["normal"], _axes(model, state, options["frame"]), "the normal")
    return -float(dot(normal, point_velocity(model, state, _point(model, options["at"]))))


def resolved_blow(
    model: Model, state: State, at: Any, impulse: Vector | None, moment: Vector | None, frame: Any
) -> tuple[Point, Vector, Vector]:
    """Return the point of a blow, its impulse and its moment impulse in ground axes [N s, N m s]; arguments as of
    :func:`impulse`.
    """
    point = _point(model, at)
    if impulse is None and moment is None:
        raise ModelError(
            "Expected an impulse, impulse=(Jx, Jy, Jz), a moment impulse, or normal= and restitution=."
        )
    R = _axes(model, state, frame)
    return (
        point,
        ZERO if impulse is None else _vector(state, impulse, R, "the impulse"),
        ZERO if moment is None else _vector(state, moment, R, "the moment impulse"),
    )


def _axes(model: Model, state: State, frame: Any) -> Matrix | None:
    """Return the rotation to ground axes of a frame, None for ground axes."""
    return None if frame is None else rotation(model, state, place_of(model, _frame(model, frame))[0])


def centre_of_percussion(
    s: Any, joint: Any, *, direction: Any = None, along: Any = None, body: Any = None, frame: Any = None
) -> Any:
    """Return the distance from a joint at which a blow causes no impulse in the joint along its direction.

    Parameters
    ----------
    s : System, Model or Equations
    joint : Joint or name
    direction : three components, optional
        Direction of the blow, in ground axes or the axes of ``frame``; if not given, perpendicular to the line and, for
        a hinge, to its axis, in body axes.
    along : three components, optional
        Direction of the line through the joint's point on which the blow falls, in body axes; towards the mass centre
        if not given. Distances are multiples of its length.
    body : Body or name, optional
        Body that is struck: the joint's child if not given.
    frame : Body, optional
        Body in whose axes ``direction`` is.

    Returns
    -------
    SymPy expression
        Distance h.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bat")
    >>> m, L = s.parameters(m=1, L=1)
    >>> bat = s.body("bat", fb.slender_bar(m, L, axis="y"))
    >>> grip = s.hinge("grip", s.ground, bat, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> fb.centre_of_percussion(s, grip)
    2*L/3
    """
    e = _equations(s, "fb.centre_of_percussion")
    model, state = e.model, e.state
    name = joint if isinstance(joint, str) else str(getattr(joint, "name", joint))
    if name not in model.joints:
        raise ModelError(f"Unknown joint '{name}'; {nearest(name, model.joints)}")
    place = model.joints[name]
    named = body if body is None or isinstance(body, str) else own_body(model, body, "a blow").name
    struck = place.child if named is None else named
    if struck not in (place.child, place.parent) or struck == "ground":
        raise ModelError(
            f"Joint '{name}' joins '{place.parent}' and '{place.child}'; expected one of them as the body that is "
            f"struck, got '{struck}'."
        )
    start = place.to if struck == place.child else place.at
    centre = model.bodies[struck].center
    line = along
    if line is None:
        line = [sympy.sympify(c) - sympy.sympify(a) for c, a in zip(centre, start, strict=True)]
        length = sympy.sqrt(sum(sympy.expand(x) ** 2 for x in line))
        if length == 0:
            raise ModelError(
                f"The mass centre of '{struck}' is at joint '{name}': no line through both. Give along=, the direction "
                f"of the line on which the blow falls."
            )
        line = [sympy.simplify(x / length) for x in line]
        line = [x.xreplace({sympy.Abs(p): p for p in x.free_symbols}) for x in line]
    line = [model.names.expression(x, "along") for x in line]
    R_body = rotation(model, state, model.bodies[struck].link)
    if direction is None:
        link = model.links[place.links[-1]]
        if not link.turns_only or len(place.links) != 1:
            raise ModelError(
                f"Joint '{name}' is no hinge: give the direction of the blow, direction=(x, y, z)."
            )
        axis = sympy.Matrix(link.axis)
        blow = apply(R_body, state.vector(list(axis.cross(sympy.Matrix(line)))))
    else:
        blow = _vector(state, direction, _axes(model, state, frame), "the direction")
    result = percussion(e, name, start, line, blow, _Struck(struck))
    return next(iter(result.branches[0].values()))


class _Struck:
    """A body of the model, given by its name."""

    is_ground = False

    def __init__(self, name: str) -> None:
        self.name = name


def _equations(s: Any, question: str) -> Equations:
    """Return the equations of a System, Model or Equations."""
    if isinstance(s, Equations):
        return s
    if isinstance(s, System):
        s = assemble(s)
    if not isinstance(s, Model):
        raise ModelError(f"Expected a System, a Model or Equations, got {s!r}.")
    check_modes_are_chosen(s, question)
    return Equations(s)


def _point(model: Model, at: Any) -> Point:
    """Return the point at which an impulse acts."""
    if isinstance(at, Body):
        at = at.origin
    if not isinstance(at, Point):
        raise ModelError(f"Expected a point, such as at=bar.point(0, 1, 0), for an impulse, got {at!r}.")
    own_body(model, at.body, "an impulse")
    if at.body.is_ground:
        raise ModelError("An impulse on the ground moves nothing. Give a point of a body.")
    return at


def _frame(model: Model, frame: Any) -> Any:
    return own_body(model, frame, "the frame of an impulse")


def _vector(state: State, components: Any, R: Matrix | None, what: str) -> Vector:
    """Return a vector in ground axes."""
    names = state.model.names
    if isinstance(components, str) or not hasattr(components, "__len__") or len(components) != 3:
        raise ModelError(f"Expected three components (x, y, z) for {what}, got {components!r}.")
    v = state.vector([names.expression(c, what) for c in components])
    return v if R is None else apply(R, v)


def _exact_state(e: Equations, initial: Mapping[Any, Any], t: Expression | None) -> State:
    """Return the symbolic state, with exact values of named coordinates and speeds."""
    model, ring = e.model, e.ring
    if not isinstance(initial, Mapping):
        raise ModelError(f"Expected initial values by name, such as {{'theta': 0}}, got {initial!r}.")
    vocabulary = Vocabulary(e)
    names = model.state_names
    elements = dict(zip(names, [*e.state.q, *e.state.u], strict=True))
    quaternions = quaternions_by_joint(model)
    for key, value in initial.items():
        name = model.names.text_of(key)
        if name in quaternions:
            parts: Sequence[Any] = value.as_quaternion() if isinstance(value, Rotation) else value
            for k, part in enumerate(parts):
                elements[names[quaternions[name] + k]] = vocabulary.element(
                    part, f"the initial quaternion of '{name}'"
                )
        elif name in elements:
            elements[name] = vocabulary.element(value, f"the initial value of '{name}'")
        else:
            raise ModelError(f"Unknown name '{name}' in initial; {nearest(name, [*names, *quaternions])}")
    values = list(elements.values())
    time = e.state.t if t is None else vocabulary.element(t, "t")
    return State(model, ring, time, values[: model.n_q], values[model.n_q :], e.state.values)
