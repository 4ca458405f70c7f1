"""``fb.impulse``: what a blow, or an impact with given restitution, does to a machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from ...describe.body import Body
from ...describe.frame import Point
from ...describe.system import System
from ...dynamics.constrained import independent_rows
from ...dynamics.kinematics import place_of, rotation
from ...dynamics.state import State, float_state
from ...errors import ModelError, arguments_named, nearest
from ...model.assemble import assemble
from ...model.model import Model
from ...model.values import check_assumptions
from ...scalar.algebra import ZERO, Vector, apply
from ...space.rotation import Rotation
from ...symbolic.derivation.bodies import own_body
from ...symbolic.equations import Equations
from ...symbolic.impulses.impulse import Struck
from ...symbolic.impulses.impulse_jumps import exact_jumps, float_jumps, percussion, restituted
from ...symbolic.solving.vocabulary import Vocabulary
from ..kernels.kernels import kernels_of
from ..start.initial import initial_state, number
from ..start.loop_closure import closed_start


@arguments_named
def impulse(
    s: Any,
    *,
    at: Any = None,
    impulse: Any = None,
    moment: Any = None,
    frame: Any = None,
    normal: Any = None,
    restitution: Any = None,
    initial: Any = None,
    values: Mapping[Any, Any] | None = None,
    t: Any = None,
    near: Mapping[Any, Any] | None = None,
) -> Struck:
    """Speeds just after an impulse, and the impulsive reactions of all joints.

        M Δu = Jᵀ P + Gᵀ Λ,    G Δu = 0

    Parameters
    ----------
    s : System, Model or Equations
    at : Point or Body
        Where the impulse acts; of a body, its origin.
    impulse : three numbers or expressions, optional
        Its components [N s].
    moment : three numbers or expressions, optional
        A moment impulse on the same body besides [N m s].
    frame : Body, optional
        The axes of the components; ground axes if not given.
    normal, restitution : three components and a number, optional
        In place of an impulse: the point meets a smooth surface fixed in the ground whose normal points to the body,
        n·v⁺ = -e n·v⁻ (Newton).
    initial : mapping, or Trajectory, optional
        The state just before, as for :func:`simulate`; of a trajectory, its last one, with its values. Without
        ``values`` what is not named stays a symbol.
    values : mapping, optional
        Values of parameters in place of their defaults. If given, even empty, everything is computed with numbers;
        without it the result is exact.
    t : number, optional
        The time, for driven machines [s].
    near : mapping, optional
        Where to look for coordinates that close loops, as for :func:`simulate`.

    Returns
    -------
    Struck
        ``.after`` (speeds by name), ``.reactions``, ``.energy_change``, ``.initial`` (for the next ``simulate``),
        ``.solve("pin_x = 0", for_="h")``.

    Raises
    ------
    ModelError
        A point of another system, no impulse, an impact that can not be, and what the initial state may lack.

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
      pin_x = -(2*L - 3*h)*J/(2*L)
    >>> hit.solve("pin_x = 0", for_="h")
    h = 2*L/3
    """
    e = _equations(s)
    model = e.model
    point = _point(model, at)
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
        state = float_state(model, y[: model.n_q].tolist(), y[model.n_q :].tolist(), begin, values)
        jumps = float_jumps(model, state, active or independent_rows(model, state))
    if normal is not None or restitution is not None:
        if impulse is not None or normal is None or restitution is None:
            raise ModelError(
                "Expected either impulse=, or normal= and restitution= together, by which the impulse is found."
            )
        direction = _vector(state, normal, _axes(model, state, frame), "the normal")
        if all(c == 0 for c in direction):
            raise ModelError(f"Expected a direction for the normal, got {normal!r}.")
        e_N = state(model.names.expression(restitution, "the coefficient of restitution"))
        P = restituted(e, state, jumps, point, direction, e_N)
        _, _, n = given_blow(model, state, point, ZERO, moment, frame)
    else:
        _, P, n = given_blow(model, state, point, impulse, moment, frame)
    return Struck(e, state, jumps, [(point, P, n)])


def given_blow(
    model: Model, state: State, at: Any, impulse: Any, moment: Any, frame: Any
) -> tuple[Point, Vector, Vector]:
    """The point of a blow, its impulse and its moment impulse in ground axes [N s, N m s]; arguments of
    :func:`impulse`."""
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


def _axes(model: Model, state: State, frame: Any) -> Any:
    return None if frame is None else rotation(model, state, place_of(model, _frame(model, frame))[0])


def centre_of_percussion(
    s: Any, joint: Any, *, direction: Any = None, along: Any = None, body: Any = None, frame: Any = None
) -> Any:
    """Distance from a joint at which a blow leaves the joint without an impulse along it.

    Parameters
    ----------
    s : System, Model or Equations
    joint : Joint or name
    direction : three components, optional
        Of the blow, in ground axes or those of ``frame``; if not given, at right angles to the line and, of a hinge,
        to its axis, in body axes.
    along : three components, optional
        Direction of the line through the joint's point on which the blow falls, in axes of the body; towards its
        mass centre if not given. Distances are multiples of its length.
    body : Body or name, optional
        The body that is struck: the joint's child if not given.
    frame : Body, optional
        The axes of ``direction``.

    Returns
    -------
    SymPy expression
        The distance h.

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
    e = _equations(s)
    model, state = e.model, e.state
    name = joint if isinstance(joint, str) else str(getattr(joint, "name", joint))
    if name not in model.joints:
        raise ModelError(f"Unknown joint '{name}'; {nearest(name, model.joints)}")
    place = model.joints[name]
    struck = (
        place.child
        if body is None
        else body
        if isinstance(body, str)
        else own_body(model, body, "a blow").name
    )
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
        if link.kind != "hinge" or len(place.links) != 1:
            raise ModelError(
                f"Joint '{name}' is no hinge: give the direction of the blow, direction=(x, y, z)."
            )
        axis = sympy.Matrix(link.axis)
        blow = apply(R_body, state.vector(list(axis.cross(sympy.Matrix(line)))))
    else:
        R = None if frame is None else rotation(model, state, place_of(model, _frame(model, frame))[0])
        blow = _vector(state, direction, R, "the direction")
    result = percussion(e, name, start, line, blow, _Struck(struck))
    return next(iter(result.branches[0].values()))


class _Struck:
    """A body of the model by name."""

    is_ground = False

    def __init__(self, name: str) -> None:
        self.name = name


def _equations(s: Any) -> Equations:
    if isinstance(s, Equations):
        return s
    if isinstance(s, System):
        s = assemble(s)
    if not isinstance(s, Model):
        raise ModelError(f"Expected a System, a Model or Equations, got {s!r}.")
    return Equations(s)


def _point(model: Model, at: Any) -> Point:
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


def _vector(state: State, components: Any, R: Any, what: str) -> Vector:
    names = state.model.names
    if isinstance(components, str) or not hasattr(components, "__len__") or len(components) != 3:
        raise ModelError(f"Expected three components (x, y, z) for {what}, got {components!r}.")
    v = state.vector([names.expression(c, what) for c in components])
    return v if R is None else apply(R, v)


def _exact_state(e: Equations, initial: Mapping[Any, Any], t: Any) -> State:
    """The symbolic state, with exact values of what is named."""
    model, ring = e.model, e.ring
    if not isinstance(initial, Mapping):
        raise ModelError(f"Expected initial values by name, such as {{'theta': 0}}, got {initial!r}.")
    vocabulary = Vocabulary(e)
    names = [*model.coordinate_names, *model.speed_names]
    given = dict(zip(names, [*e.state.q, *e.state.u], strict=True))
    turned = {
        link.joint: link.q + (3 if link.kind == "free" else 0)
        for link in model.links
        if link.kind in ("ball", "free")
    }
    for key, value in initial.items():
        name = key if isinstance(key, str) else model.names.texts.get(key, str(key))
        if name in turned:
            parts: Sequence[Any] = value.as_quaternion() if isinstance(value, Rotation) else value
            for k, part in enumerate(parts):
                given[names[turned[name] + k]] = vocabulary.element(
                    part, f"the initial quaternion of '{name}'"
                )
        elif name in given:
            given[name] = vocabulary.element(value, f"the initial value of '{name}'")
        else:
            raise ModelError(f"Unknown name '{name}' in initial; {nearest(name, [*names, *turned])}")
    values = list(given.values())
    time = e.state.t if t is None else vocabulary.element(t, "t")
    return State(model, ring, time, values[: model.n_q], values[model.n_q :], e.state.values)
