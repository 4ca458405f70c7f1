"""Solution of the free-body equations for chosen unknowns.

    Σ F = m a_C,   Σ M_C = dH_C/dt   of every body, and the user's values and equations: T = mu N, ...

Linear systems are solved exactly: every pivot is proven to be different from zero. A request without a solution is
refused with the equations that remain. Polynomial systems of higher degree are solved if the roots have a closed form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import sympy

from ...dynamics.joints.freedom import free_displacements
from ...dynamics.joints.motions import path_speeds
from ...errors import ModelError
from ...model.contact_modes import Touching
from ...scalar.algebra import Scalar
from ...scalar.element import Polynomial
from ...scalar.polynomial import Ring
from ...scalar.ratio import Ratio, over_sine
from ...scalar.substitute import Substitution
from ..derivation.derivation import Derivation
from ..free_body.action import TITLES
from ..free_body.contact_forces import sliding_friction
from ..free_body.free_body import FreeBody, free_body
from ..free_body.gears import radial_law, radial_symbols, undetermined_by_couplings
from ..printing.display import equation_text, text
from ..printing.fractions import ratio_displayed
from ..printing.systems import Monomial, Pivot, Row, Terms, collect, eliminate
from .polynomial_roots import roots
from .request import Request, Unknown
from .solution import Branch, SolveResult
from .steps import LONG, steps


def solve(
    e: Derivation, unknowns: Any, where: Any = None, bodies: Any = None, eliminate_also: Any = ()
) -> SolveResult:
    """Solve the free-body equations for unknowns; see :meth:`Equations.solve`."""
    request = Request(e)
    sliding = sliding_friction(e)
    request.vocabulary.extend({name: symbol for name, (symbol, _, _) in sliding.items()})
    request.vocabulary.reactions.update({name: symbol for name, (symbol, _, _) in sliding.items()})
    request.vocabulary.owner.update({name: owner for name, (_, _, owner) in sliding.items()})
    request.read_unknowns(unknowns)
    also = [eliminate_also] if isinstance(eliminate_also, str | sympy.Basic) else list(eliminate_also)
    request.read_where(where)
    _add_radial_forces(e, request, where)
    whole = bodies is None and not sliding
    reactions = _reactions_beside_accelerations(request) if whole and not also else None
    if reactions and not e.model.constraints:
        return _in_two_steps(
            request, solve(e, list(request.vocabulary.accelerations), where), reactions, where
        )
    if reactions == []:  # the equations of motion suffice
        motion = set(range(e.model.n_u))
    else:
        turning = _speeds_of_turning(e) if whole else {}
        for body in free_bodies(e, bodies):
            for title, (left, right) in zip(TITLES, body.balances, strict=True):
                if not (body.body in turning and title.startswith("moment")):
                    request.add(f"{body.body}: {title}", left - right)
        motion = {j for rows in turning.values() for j in rows} | (_shared_speeds(e) if whole else set())
    for j in sorted(motion):
        left, right = e.balances[j]
        request.add(f"equation of motion of {e.model.speed_names[j]}", left - right)
    for symbol, friction, owner in sliding.values():
        request.add(f"sliding friction of '{owner}'", e.ring.generator(symbol, "reaction") - friction)
    return solution_of(request, also)


def _add_radial_forces(e: Derivation, request: Request, where: Any) -> None:
    """Add the radial forces of gears to a request for reactions: tan(alpha) |F_t|, with F_t solved for beforehand.

    Raises
    ------
    ModelError
        A reaction that a coupling by its ratio leaves undetermined.
    """
    names = {u.name for u in request.unknowns}
    owner, symbols = request.vocabulary.owner, radial_symbols(e)
    forces = {gear: name for name, gear in owner.items() if gear in symbols and name != symbols[gear].name}
    reactions = names & set(request.vocabulary.reactions) - set(forces.values())
    given_atoms = {symbol for _, x in request.equations for symbol in e.ring.atoms_of(x)} | set(
        request.values
    )
    loaded = {owner[name] for name, symbol in request.vocabulary.reactions.items() if symbol in given_atoms}
    for joint in dict.fromkeys(owner[name] for name in reactions):
        for note in undetermined_by_couplings(e, joint):
            raise ModelError(
                f"{note[0].upper()}{note[1:]}. The sum of both is in fb.equations(s).reactions['{joint}']."
            )
    for gear, force in forces.items():
        law = radial_law(e, gear)
        if symbols[gear].name in request.value_names:
            continue
        if not reactions:
            if loaded & {gear, e.model.constraints[gear].first.name, e.model.constraints[gear].second.name}:
                request.add(f"pressure angle of '{gear}'", e.ring.generator(symbols[gear], "reaction") - law)
            continue
        others = [u.expression for u in request.unknowns if u.name not in request.vocabulary.reactions]
        try:
            tangential = solve(e, [force, *others], where).ratios[force]
        except ModelError:
            continue  # the unknowns may not depend on it
        size = [e.ring.apply("abs", x) for x in (tangential.num, tangential.den)]
        (multiplier,) = (x for x in e.multipliers if x.name == force)
        value = Substitution(e.ring, e.ring, {multiplier: e.ring.coerce(1)})(law) * size[0] / size[1]
        if symbols[gear].name in names:
            request.add(f"pressure angle of '{gear}'", e.ring.generator(symbols[gear], "reaction") - value)
        else:
            request.values[symbols[gear]] = value


def _reactions_beside_accelerations(request: Request) -> list[str] | None:
    """Names of the reactions in a request for all accelerations, and for reactions at most.

    None for other requests, and if the equations of motion alone do not determine the accelerations.
    """
    vocabulary, ring = request.vocabulary, request.ring
    names = {u.name for u in request.unknowns}
    others = names - set(vocabulary.accelerations)
    if len(names - others) < len(vocabulary.accelerations) or not others <= set(vocabulary.reactions):
        return None
    if any(isinstance(c, Touching) for c in request.e.model.constraints.values()):
        return None
    expressions = [x for _, x in request.equations] + list(request.values.values())
    symbols = set(request.values).union(*(ring.atoms_of(x) for x in expressions))
    return None if symbols & set(vocabulary.reactions.values()) else sorted(others)


def _in_two_steps(request: Request, motion: SolveResult, reactions: Sequence[str], where: Any) -> SolveResult:
    """Put the solved accelerations into the reactions; an elimination of both at once is far longer."""
    e, ring, vocabulary = request.e, request.ring, request.vocabulary
    (accelerations,) = motion._solutions
    by_motion = solve(e, reactions, where).ratios
    places = {g.index: (name, 1) for name, a in vocabulary.accelerations.items() if (g := ring.find(a))}
    ratios = dict(accelerations.ratios)
    for name, r in by_motion.items():
        total = Ratio(ring, 0)
        for monomial, c in collect(r.num, places, ring).items():
            for v, _ in monomial:
                c = c * accelerations.ratios[v]
            total = total + c / Ratio(ring, r.den)
        ratios[name] = total.tidy()
    names = [u.name for u in request.unknowns]
    values = {name: ratio_displayed(ratios[name], ring) for name in reactions} | dict(motion)
    lines: Sequence[tuple[str, Ratio]] = ()
    if any(len(r) > LONG for r in ratios.values()):
        lines = [*(accelerations.lines or accelerations.ratios.items()), *by_motion.items()]
    branch = Branch(
        {name: ratios[name] for name in names},
        {name: values[name] for name in names},
        lines,
        accelerations.names,
    )
    return SolveResult(e, vocabulary, [branch], ())


def _speeds_of_turning(e: Derivation) -> dict[str, tuple[int, ...]]:
    """Bodies on ball and free joints -> speeds whose equations of motion replace the moment equations of the body.

    They are Rᵀ times the moment equations, plus force equations and equations of the carried bodies. The content is the
    same, but in the body's axes, where the inertia is constant and u' has no factors of the quaternion.
    """
    model = e.model
    result = {}
    for joint in model.joints.values():
        link = model.links[joint.links[-1]]
        if link.u >= 0:
            result[joint.child] = tuple(range(link.u, link.u + 3))
    return result


def _shared_speeds(e: Derivation) -> set[int]:
    """Speeds of coordinates that several joints share, if no displacement follows such a coordinate alone.

    The coupling of these joints does no work in total. The equation of motion contains that, the free bodies do not.
    """
    followed = {j for _, j in free_displacements(e.model)}
    for joint in e.model.joints.values():
        followed |= set(path_speeds(e.model, joint)) if joint.pair.path else set()
    return {j for link in e.model.links for j, _ in link.partials} - followed


def free_bodies(e: Derivation, bodies: Any) -> list[FreeBody]:
    """Return the free bodies of a request: all by default, else bodies by name or free bodies."""
    if bodies is None:
        return [free_body(e, name) for name in e.model.bodies]
    if isinstance(bodies, str | FreeBody) or hasattr(bodies, "mass_properties"):
        bodies = [bodies]
    result = []
    for body in bodies:
        if isinstance(body, FreeBody):
            if body._e is not e:
                raise ModelError(
                    f"The free body '{body.body}' belongs to other equations. Make it by free_body of these."
                )
            result.append(body)
        else:
            result.append(free_body(e, body))
    return result


def solution_of(request: Request, also: Sequence[Any] = ()) -> SolveResult:
    """Solve the equations of a request; ``also`` are further unknowns to eliminate."""
    vocabulary, e = request.vocabulary, request.e
    names = {u.name for u in request.unknowns}
    fixed = request.value_names
    free = {
        name: symbol
        for name, symbol in vocabulary.reactions.items()
        if name not in names and name not in fixed
    }
    for unknown in also:
        expression = vocabulary.expression(unknown, "the unknowns to eliminate")
        free[vocabulary.name(expression)] = expression
    accelerations: dict[str, Any] = {}
    # in 3-D the accelerations are far longer than the equations from which they would be eliminated
    touching = any(isinstance(c, Touching) and c.contact.tangents < 2 for c in e.model.constraints.values())
    of_motion = any(
        u.name in vocabulary.reactions or u.name in vocabulary.accelerations for u in request.unknowns
    )
    if touching or not of_motion:
        accelerations = {
            name: symbol
            for name, symbol in vocabulary.accelerations.items()
            if name not in names and name not in fixed and name not in free
        }
    moving = [u for u in (*names, *free, *accelerations) if u in vocabulary.accelerations]
    if moving and e.model.constraints:
        for name, row, bias in zip(e.condition_names, e.conditions.matrix, e.conditions.bias, strict=True):
            total = bias
            for entry, udot in zip(row, e.udot, strict=True):
                total = total + entry * udot
            request.add(f"constraint '{name}', differentiated", total)
    rows = request.rows({**free, **accelerations})
    keys = [key for u in request.unknowns for key in u.keys]
    before = [row.terms for row in rows]
    pivots: list[Pivot] = []
    solved, remaining = eliminate(rows, [[*keys, *free], list(accelerations)], pivots)
    parameters = set(accelerations) - set(solved)  # accelerations that no equation determines
    open_rows = [row for row in remaining if row.unknowns - parameters]
    joint_unknowns = {v for row in remaining for v in row.unknowns}
    if parameters & joint_unknowns and len(joint_unknowns) <= len([row for row in remaining if row.terms]):
        parameters -= joint_unknowns  # as many equations as unknowns, but not linear in them
        open_rows = [row for row in remaining if row.unknowns]
    closed_rows = [row for row in remaining if row not in open_rows]
    _check_determined(request, solved, open_rows, free, parameters)
    conditions = _conditions(request, closed_rows, accelerations)
    symbols = {key: sympy.Dummy(key, real=True) for row in rows for key in row.unknowns}
    branches = roots(open_rows, request.ring, parameters, symbols)
    solutions = [_branch(request, solved, branch, {**free, **accelerations}) for branch in branches]
    # omit roots that differ only in eliminated unknowns
    solutions = [
        s for i, s in enumerate(solutions) if all(s.values != other.values for other in solutions[:i])
    ]
    if not solutions:
        raise ModelError(
            f"There is no real solution for {', '.join(names)}; remaining equations: "
            + "; ".join(_row_text(row) for row in open_rows)
        )
    if not open_rows and any(len(r) > LONG for r in solutions[0].ratios.values()):
        places = {key: e.ring.variable(i) ** power for i, (key, power) in request.places.items()}
        places |= {name: e.ring.generator(a) for name, a in {**free, **accelerations}.items()}
        reserved = [*vocabulary.names, *(str(a) for a in fixed)]
        lines, coefficients = steps(e.ring, before, pivots, places, keys, reserved)
        solutions = [replace(solutions[0], lines=lines, names=coefficients)]
    return SolveResult(e, vocabulary, solutions, conditions)


def _check_determined(
    request: Request,
    solved: Mapping[str, Terms],
    rows: Sequence[Row],
    free: Mapping[str, Any],
    parameters: set[str],
) -> None:
    """Refuse a request unless its unknowns are solved, or remain in as many equations as unknowns."""
    open_keys = {v for row in rows for v in row.unknowns} - parameters
    keys = [key for u in request.unknowns for key in u.keys]
    needed: set[str] = set()
    for key in keys:
        if key in solved:
            needed |= {v for monomial in solved[key] for v, _ in monomial} - parameters - open_keys
        elif key not in open_keys:
            needed.add(key)
    if not needed and len(open_keys) <= len(rows):
        return
    lacking = sorted(needed | (open_keys if len(open_keys) > len(rows) else set()))
    counts = f"{len(request.equations)} equations"
    remaining = "; ".join(_row_text(row) for row in rows)
    quoted = [f"'{name}'" for name in lacking]
    hint = ""
    loose = [name for name in lacking if name in free]
    if loose:
        owners = sorted(
            {request.vocabulary.owner[name] for name in loose if name in request.vocabulary.owner}
        )
        hint = f" {', '.join(loose)} act in {', '.join(map(repr, owners))}: take the bodies there too, or"
    raise ModelError(
        f"Under-determined: {counts} do not determine {', '.join(quoted)}."
        + (f" Remaining equations: {remaining}." if remaining else "")
        + (hint or " Ask for fewer unknowns, or")
        + f" fix a value, where={{'{lacking[0]}': ...}}."
    )


def _conditions(request: Request, rows: Sequence[Row], accelerations: Mapping[str, Any]) -> list[Scalar]:
    """Return the conditions of the rows without unknowns on the motion; any other condition is a contradiction."""
    ring = request.ring
    result: list[Scalar] = []
    accelerated = 0
    for symbol in request.vocabulary.accelerations.values():
        g = ring.find(symbol)
        if g is not None:
            accelerated |= 1 << g.index
    for row in rows:
        if any(monomial for monomial in row.terms):
            continue  # with an acceleration that no equation determines
        x = row.terms[()].num
        if type(x) is Polynomial and ring.depends(x) & accelerated:
            x = _primitive(ring, x, accelerated)
            if not any(x == y or x == -y for y in result):
                result.append(x)
            continue
        unknowns = ", ".join(u.name for u in request.unknowns)
        x = -x if text(x, ring).startswith("-") else x
        raise ModelError(
            f"Over-determined: {len(request.equations)} equations for {unknowns}; '{equation_text(x, 0, ring)}' "
            f"remains (from '{row.name}'). Ask also for an unknown that it contains, or remove a condition from where."
        )
    return result


def _primitive(ring: Ring, x: Polynomial, mask: int) -> Scalar:
    """Return the factors of x that depend on generators of the mask, with the sign that prints no leading minus."""
    _, factors = ring.factor(x)
    result: Scalar = 1
    for f, _ in factors:
        if ring.depends(f) & mask:
            result = result * f
    for g in ring.used(result) if type(result) is Polynomial else ():
        sine = g.index if g.kind == "sin" else g.partner if g.kind == "cos" else -1
        while sine >= 0 and (shorter := over_sine(ring, result, sine)) is not None:
            result = shorter
    if type(result) is not Polynomial:
        return x
    result = result * result.den / int(ring.promoted(result.num).content())
    return -result if text(result, ring).startswith("-") else result


def _row_text(row: Row) -> str:
    return f"{row.name} (in {', '.join(sorted(row.unknowns))})"


def _branch(
    request: Request, solved: Mapping[str, Terms], roots: Mapping[str, Any], hidden: Mapping[str, Any]
) -> Branch:
    """Return the values of the unknowns for one set of roots of the rows that are not linear."""
    ring = request.ring
    ratios: dict[str, Ratio] = {}
    values: dict[str, Any] = {}
    of_key: dict[str, Any] = {}
    for u in request.unknowns:
        for key in u.keys:
            terms = solved.get(key)
            if terms is not None and all(
                not monomial or _is_parametric(monomial, hidden, roots) for monomial in terms
            ):
                total = Ratio(ring, 0)
                for monomial, c in terms.items():
                    for name, n in monomial:
                        c = c * ring.generator(hidden[name]) ** n
                    total = total + c
                total = total.tidy()
                of_key[key] = ratio_displayed(total, ring)
                if u.keys == (u.name,):
                    ratios[u.name] = total
            elif terms is not None:
                value = sympy.Integer(0)
                for monomial, c in terms.items():
                    factor = ratio_displayed(c.tidy(), ring)
                    for name, n in monomial:
                        factor *= (roots[name] if name in roots else hidden[name]) ** n
                    value += factor
                of_key[key] = value
            else:
                of_key[key] = roots[key]
        values[u.name] = of_key[u.name] if u.keys == (u.name,) else _angle(u, of_key)
    return Branch(ratios, values)


def _is_parametric(monomial: Monomial, hidden: Mapping[str, Any], roots: Mapping[str, Any]) -> bool:
    """True if a monomial consists of accelerations that no equation determines."""
    return all(name in hidden and name not in roots for name, _ in monomial)


def _angle(u: Unknown, values: Mapping[str, Any]) -> Any:
    """Return an angle from its sine and cosine, in the shortest way; from one of them, the angle nearest to zero."""
    s, c = values.get(f"sin({u.name})"), values.get(f"cos({u.name})")
    if s is not None and c is not None:
        ways = [sympy.atan2(s, c)]
        if s.is_nonnegative or s.is_nonpositive:
            ways.append(sympy.acos(c) if s.is_nonnegative else -sympy.acos(c))
        if c.is_nonnegative:
            ways.append(sympy.asin(s))
        return min(ways, key=sympy.count_ops)
    return sympy.asin(s) if c is None else sympy.acos(c)
