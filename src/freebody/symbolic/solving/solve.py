"""What the free-body equations say about chosen unknowns.

    Σ F = m a_C,   Σ M_C = dH_C/dt   of every body, and what the user adds: fixed values, T = mu N, ...

Linear systems are solved exactly: every pivot is proven to be different from zero, and a request that can not be met
names what is left. What is polynomial beyond that is solved by roots where they have a closed form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import sympy

from ...dynamics.joint_freedom import free_displacements
from ...errors import ModelError
from ...model.contact import Touching
from ...scalar.element import Polynomial
from ...scalar.ratio import Ratio, over_sine
from ...scalar.substitute import Substitution
from ..derivation.derivation import Derivation
from ..free_body.action import TITLES
from ..free_body.contact_forces import sliding_friction
from ..free_body.free_body import FreeBody, free_body
from ..free_body.gears import radial_law, radial_symbols, undetermined_by_gears
from ..printing.display import equation_text, text
from ..printing.fractions import ratio_displayed
from ..printing.systems import Pivot, Row, collect, eliminate
from .polynomial_roots import roots
from .request import Request, Unknown
from .solution import Branch, SolveResult
from .steps import LONG, steps


def solve(
    e: Derivation, unknowns: Any, where: Any = None, bodies: Any = None, eliminate_also: Any = ()
) -> SolveResult:
    """See :meth:`Equations.solve`."""
    request = Request(e)
    sliding = sliding_friction(e)
    request.vocabulary.also({name: symbol for name, (symbol, _, _) in sliding.items()})
    request.vocabulary.reactions.update({name: symbol for name, (symbol, _, _) in sliding.items()})
    request.vocabulary.owner.update({name: owner for name, (_, _, owner) in sliding.items()})
    request.ask(unknowns)
    also = [eliminate_also] if isinstance(eliminate_also, str | sympy.Basic) else list(eliminate_also)
    request.fix(where)
    _fix_radial(e, request, where)
    whole = bodies is None and not sliding
    if whole and not also and not e.model.constraints and (others := _beside_accelerations(request)):
        return _put_together(request, solve(e, list(request.vocabulary.accelerations), where), others, where)
    if whole and not also and _of_motion_alone(request):
        motion = set(range(e.model.n_u))
    else:
        turning = _turning(e) if whole else {}
        for body in chosen(e, bodies):
            for title, (left, right) in zip(TITLES, body.balances, strict=True):
                if not (body.body in turning and title.startswith("moment")):
                    request.add(f"{body.body}: {title}", left - right)
        motion = {j for rows in turning.values() for j in rows} | (_shared(e) if whole else set())
    for j in sorted(motion):
        left, right = e.balances[j]
        request.add(f"equation of motion of {e.model.speed_names[j]}", left - right)
    for symbol, friction, owner in sliding.values():
        request.add(f"sliding friction of '{owner}'", e.ring.generator(symbol, "reaction") - friction)
    return answer(request, also)


def _fix_radial(e: Derivation, request: Request, where: Any) -> None:
    """Where reactions are asked for, what presses teeth apart as a value, tan(alpha) |F_t| of the F_t found before.

    Raises
    ------
    ModelError
        A reaction that a gear leaves open.
    """
    asked = {u.name for u in request.asked}
    owner, symbols = request.vocabulary.owner, radial_symbols(e)
    forces = {gear: name for name, gear in owner.items() if gear in symbols and name != symbols[gear].name}
    reactions = asked & set(request.vocabulary.reactions) - set(forces.values())
    given = {symbol for _, x in request.equations for symbol in e.ring.atoms_of(x)} | set(request.fixed)
    loaded = {owner[name] for name, symbol in request.vocabulary.reactions.items() if symbol in given}
    for joint in dict.fromkeys(owner[name] for name in reactions):
        for note in undetermined_by_gears(e, joint, radial=False):
            raise ModelError(
                f"{note[0].upper()}{note[1:]}. What passes through both is fb.equations(s).reactions['{joint}']."
            )
    for gear, force in forces.items():
        law = radial_law(e, gear)
        if symbols[gear].name in request.fixed_names:
            continue
        if law is None and symbols[gear].name in asked:
            raise ModelError(
                f"No equation determines {symbols[gear].name}, which presses the teeth of gear '{gear}' apart. Give "
                f"the gear its pressure_angle, or a value, where={{'{symbols[gear].name}': ...}}."
            )
        if law is None:
            continue
        if not reactions:
            if loaded & {gear, e.model.constraints[gear].first.name, e.model.constraints[gear].second.name}:
                request.add(f"pressure angle of '{gear}'", e.ring.generator(symbols[gear], "reaction") - law)
            continue
        others = [u.expression for u in request.asked if u.name not in request.vocabulary.reactions]
        try:
            found = solve(e, [force, *others], where).ratios[force]
        except ModelError:
            continue  # what is asked may not depend on it
        size = [e.ring.apply("abs", x) for x in (found.num, found.den)]
        (multiplier,) = (x for x in e.multipliers if x.name == force)
        value = Substitution(e.ring, e.ring, {multiplier: e.ring.coerce(1)})(law) * size[0] / size[1]
        if symbols[gear].name in asked:
            request.add(f"pressure angle of '{gear}'", e.ring.generator(symbols[gear], "reaction") - value)
        else:
            request.fixed[symbols[gear]] = value


def _of_motion_alone(request: Request) -> bool:
    """Whether all accelerations are asked for and nothing of reactions: the equations of motion say it all."""
    return _beside_accelerations(request) == []


def _beside_accelerations(request: Request) -> list[str] | None:
    """The reactions asked for, where all accelerations are and nothing else; None where the equations of motion alone
    do not say what these are."""
    vocabulary, ring = request.vocabulary, request.ring
    asked = {u.name for u in request.asked}
    others = asked - set(vocabulary.accelerations)
    if len(asked - others) < len(vocabulary.accelerations) or not others <= set(vocabulary.reactions):
        return None
    if any(isinstance(c, Touching) for c in request.e.model.constraints.values()):
        return None
    given = [x for _, x in request.equations] + list(request.fixed.values())
    symbols = set(request.fixed).union(*(ring.atoms_of(x) for x in given))
    return None if symbols & set(vocabulary.reactions.values()) else sorted(others)


def _put_together(request: Request, motion: SolveResult, others: Sequence[str], where: Any) -> SolveResult:
    """Accelerations, and reactions by them: what eliminates both at once is far longer on the way."""
    e, ring, vocabulary = request.e, request.ring, request.vocabulary
    (found,) = motion._solutions
    by_motion = solve(e, others, where).ratios
    places = {g.index: (name, 1) for name, a in vocabulary.accelerations.items() if (g := ring.find(a))}
    ratios = dict(found.ratios)
    for name, r in by_motion.items():
        total = Ratio(ring, 0)
        for monomial, c in collect(r.num, places, ring).items():
            for v, _ in monomial:
                c = c * found.ratios[v]
            total = total + c / Ratio(ring, r.den)
        ratios[name] = total.tidy()
    asked = [u.name for u in request.asked]
    values = {name: ratio_displayed(ratios[name], ring) for name in others} | dict(motion)
    lines: Sequence[tuple[str, Ratio]] = ()
    if any(len(r) > LONG for r in ratios.values()):
        lines = [*(found.lines or found.ratios.items()), *by_motion.items()]
    branch = Branch(
        {name: ratios[name] for name in asked}, {name: values[name] for name in asked}, lines, found.names
    )
    return SolveResult(e, vocabulary, [branch], ())


def _turning(e: Derivation) -> dict[str, tuple[int, ...]]:
    """Bodies on ball and free joints -> the speeds whose equations of motion take the place of their moment equations.

    Those are Rᵀ times the moment equations, plus force equations and equations of the bodies that are carried: as much
    is said, but in the body's axes, where the inertia is constant and no component of the quaternion is in front of u'.
    """
    model = e.model
    result = {}
    for joint in model.joints.values():
        link = model.links[joint.links[-1]]
        if link.u >= 0:
            result[joint.child] = tuple(range(link.u, link.u + 3))
    return result


def _shared(e: Derivation) -> set[int]:
    """Speeds of coordinates that stand in several joints and that no displacement follows alone.

    What couples such joints does no work on the whole: free bodies do not say that, the equation of motion does.
    """
    followed = {j for _, j in free_displacements(e.model)}
    return {j for link in e.model.links for j, _ in link.partials} - followed


def chosen(e: Derivation, bodies: Any) -> list[FreeBody]:
    """The free bodies of a request: all, or those named, or given as free bodies."""
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


def answer(request: Request, also: Sequence[Any] = ()) -> SolveResult:
    """Solve what was read."""
    vocabulary, e = request.vocabulary, request.e
    names = {u.name for u in request.asked}
    fixed = request.fixed_names
    free = {
        name: symbol
        for name, symbol in vocabulary.reactions.items()
        if name not in names and name not in fixed
    }
    for given in also:
        expression = vocabulary.expression(given, "the unknowns to eliminate")
        free[vocabulary.name(expression)] = expression
    accelerations: dict[str, Any] = {}
    # in space the accelerations are far longer than the equations that they are eliminated from
    touching = any(isinstance(c, Touching) and c.contact.planar for c in e.model.constraints.values())
    of_motion = any(
        u.name in vocabulary.reactions or u.name in vocabulary.accelerations for u in request.asked
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
    keys = [key for u in request.asked for key in u.keys]
    before = [row.terms for row in rows]
    pivots: list[Pivot] = []
    solved, left = eliminate(rows, [[*keys, *free], list(accelerations)], pivots)
    given = set(accelerations) - set(solved)  # what no equation determines is taken as given
    open_rows = [row for row in left if row.unknowns - given]
    joined = {v for row in left for v in row.unknowns}
    if given & joined and len(joined) <= len([row for row in left if row.terms]):
        given -= joined  # as many equations as unknowns, but not linear in them
        open_rows = [row for row in left if row.unknowns]
    closed = [row for row in left if row not in open_rows]
    _check_determined(request, solved, open_rows, free, given)
    conditions = _conditions(request, closed, accelerations)
    symbols = {key: sympy.Dummy(key, real=True) for row in rows for key in row.unknowns}
    branches = roots(open_rows, request.ring, given, symbols)
    solutions = [_branch(request, solved, branch, {**free, **accelerations}) for branch in branches]
    # roots that differ only in what was not asked for
    solutions = [
        s for i, s in enumerate(solutions) if all(s.values != other.values for other in solutions[:i])
    ]
    if not solutions:
        raise ModelError(
            f"There is no real solution for {', '.join(names)}: left was "
            + "; ".join(_row_text(request, row) for row in open_rows)
        )
    if not open_rows and any(len(r) > LONG for r in solutions[0].ratios.values()):
        places = {key: e.ring.variable(i) ** power for i, (key, power) in request.places.items()}
        places |= {name: e.ring.generator(a) for name, a in {**free, **accelerations}.items()}
        taken = [*vocabulary.names, *(str(a) for a in fixed)]
        lines, coefficients = steps(e.ring, before, pivots, places, keys, taken)
        solutions = [replace(solutions[0], lines=lines, names=coefficients)]
    return SolveResult(e, vocabulary, solutions, conditions)


def _check_determined(
    request: Request, solved: Mapping[str, Any], rows: Sequence[Row], free: Mapping[str, Any], given: set[str]
) -> None:
    """Every unknown that was asked for is solved, or is left in as many equations as unknowns."""
    open_keys = {v for row in rows for v in row.unknowns} - given
    asked = [key for u in request.asked for key in u.keys]
    needed: set[str] = set()
    for key in asked:
        if key in solved:
            needed |= {v for monomial in solved[key] for v, _ in monomial} - given - open_keys
        elif key not in open_keys:
            needed.add(key)
    if not needed and len(open_keys) <= len(rows):
        return
    lacking = sorted(needed | (open_keys if len(open_keys) > len(rows) else set()))
    counts = f"{len(request.equations)} equations"
    left = "; ".join(_row_text(request, row) for row in rows)
    of = [f"'{name}'" for name in lacking]
    hint = ""
    loose = [name for name in lacking if name in free]
    if loose:
        owners = sorted(
            {request.vocabulary.owner[name] for name in loose if name in request.vocabulary.owner}
        )
        hint = f" {', '.join(loose)} act in {', '.join(map(repr, owners))}: take the bodies there too, or"
    raise ModelError(
        f"Under-determined: {counts} do not determine {', '.join(of)}."
        + (f" Left was: {left}." if left else "")
        + (hint or " Ask for fewer unknowns, or")
        + f" fix a value, where={{'{lacking[0]}': ...}}."
    )


def _conditions(request: Request, rows: Sequence[Row], accelerations: Mapping[str, Any]) -> list[Any]:
    """What the rows without unknowns demand of the motion; a demand on anything else is a contradiction."""
    ring = request.ring
    result: list[Any] = []
    accelerated = 0
    for symbol in request.vocabulary.accelerations.values():
        g = ring.find(symbol)
        if g is not None:
            accelerated |= 1 << g.index
    for row in rows:
        if any(monomial for monomial in row.terms):
            continue  # an acceleration taken as given
        x = row.terms[()].num
        if type(x) is Polynomial and ring.depends(x) & accelerated:
            x = _primitive(ring, x, accelerated)
            if not any(x == y or x == -y for y in result):
                result.append(x)
            continue
        asked = ", ".join(u.name for u in request.asked)
        x = -x if text(x, ring).startswith("-") else x
        raise ModelError(
            f"Over-determined: {len(request.equations)} equations for {asked}; left was "
            f"'{equation_text(x, 0, ring)}' (from '{row.name}'). Ask also for an unknown that stands in it, or take "
            f"back a condition of where."
        )
    return result


def _primitive(ring: Any, x: Polynomial, mask: int) -> Any:
    """The factors of x that hold what is asked for, with the sign that prints without a leading minus."""
    _, factors = ring.factor(x)
    held = [f for f, _ in factors if ring.depends(f) & mask]
    result: Any = 1
    for f in held:
        result = result * f
    for g in ring.used(result) if type(result) is Polynomial else ():
        sine = g.index if g.kind == "sin" else g.partner if g.kind == "cos" else -1
        while sine >= 0 and (shorter := over_sine(ring, result, sine)) is not None:
            result = shorter
    if type(result) is not Polynomial:
        return x
    result = result * result.den / int(ring.promoted(result.num).content())
    return -result if text(result, ring).startswith("-") else result


def _row_text(request: Request, row: Row) -> str:
    return f"{row.name} (in {', '.join(sorted(row.unknowns))})"


def _branch(
    request: Request, solved: Mapping[str, Any], found: Mapping[str, Any], hidden: Mapping[str, Any]
) -> Branch:
    """Values of all that was asked for, given the roots of the rows that are not linear."""
    ring = request.ring
    ratios: dict[str, Ratio] = {}
    values: dict[str, Any] = {}
    of_key: dict[str, Any] = {}
    for u in request.asked:
        for key in u.keys:
            terms = solved.get(key)
            if terms is not None and all(
                not monomial or _given(monomial, hidden, found) for monomial in terms
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
                        factor *= (found[name] if name in found else hidden[name]) ** n
                    value += factor
                of_key[key] = value
            else:
                of_key[key] = found[key]
        values[u.name] = of_key[u.name] if u.keys == (u.name,) else _angle(u, of_key, found)
    return Branch(ratios, values)


def _given(monomial: Any, hidden: Mapping[str, Any], found: Mapping[str, Any]) -> bool:
    return all(name in hidden and name not in found for name, _ in monomial)


def _angle(u: Unknown, values: Mapping[str, Any], found: Mapping[str, Any]) -> Any:
    """An angle from its sine and cosine; from one of them, the angle nearest to zero."""
    s, c = values.get(f"sin({u.name})"), values.get(f"cos({u.name})")
    if s is not None and c is not None:
        return sympy.atan2(s, c)
    return sympy.asin(s) if c is None else sympy.acos(c)
