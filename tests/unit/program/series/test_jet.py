"""Taylor coefficients by machine code, against the same recurrences on exact and on 60-digit numbers.

A coefficient is a sum of products: its error is bounded by a multiple of the rounding unit times the same sum of
absolute values. Those values are bounded by coefficients M ρ^-k of a majorant, so that the errors, with ρ the radius
that the coefficients themselves show, are compared at τ = ρ.
"""

import ctypes
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import coordinate_rates, traced_state
from freebody.dynamics.motion import motion
from freebody.errors import ExpressionError
from freebody.model import assemble
from freebody.motion.ode.layout import ORDERS
from freebody.native.records import padded
from freebody.program.code.lower import lower
from freebody.program.kernels import compile_tape
from freebody.program.series import jet, jet_of_lanes
from freebody.program.series.combining import combined
from freebody.program.series.recurrence import Node, Recurrence
from freebody.program.series.rewriting import shortened
from freebody.scalar.trace import ADD, CONST, DIV, INPUT, MUL, NAMES, NEG, SUB, Tape, Traced
from freebody.testing import JOINTS, random_state, random_system
from sampled import sampled

P = jet.ORDER
EPS = np.finfo(float).eps


def coefficients(tape, rates, t, y, parameters, time, state, values=()):
    """Rows y_0 ... y_P by the kernel."""
    return series(tape, rates, t, y, parameters)(time, state, values)


def series(tape, rates, t, y, parameters):
    """The kernel as a function of time, state and parameters."""
    n = len(rates)
    width = padded(n)
    kernels = compile_tape(tape, {"series": rates}, t, y, parameters, series={"series": width})

    def coefficients_at(time, state, values):
        out = np.zeros((P + 1) * width)
        c = np.zeros(max(kernels.hoisted, 1))
        c[: kernels.hoisted] = kernels.constants(np.array(values, dtype=float))
        start = np.zeros(width)
        start[: len(state)] = state
        kernels["series"]._function(time, start.ctypes.data, c.ctypes.data, out.ctypes.data)
        return out.reshape(P + 1, width)[:, :n]

    return coefficients_at


def coefficients_of_eight(tape, rates, t, y, parameters, times, states, values):
    """The same of eight motions at once, shape (8, P + 1, n); ``values`` has a row of parameters for each."""
    n = len(rates)
    kernels = compile_tape(tape, {"series": rates}, t, y, parameters, ["series"], {"series": n})

    def aligned(rows):
        """Entry i of motion l at 8 i + l, from a multiple of 64 bytes."""
        flat = np.ascontiguousarray(np.asarray(rows, dtype=float).reshape(8, -1).T).ravel()
        room = np.zeros(flat.size + 16)
        start = -(room.ctypes.data // 8) % 8
        room[start : start + flat.size] = flat
        return room[start:]

    c = aligned([kernels.constants(np.array(row, dtype=float)) for row in values])
    out = aligned(np.zeros((8, kernels["series"].room // 8)))
    given = (aligned(np.asarray(times)[:, None]), aligned(states), c, out)
    signature = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)
    signature(kernels["series"].lanes_address)(*(array.ctypes.data for array in given))
    return out[: 8 * (P + 1) * n].reshape(P + 1, n, 8).transpose(2, 0, 1)


def reference(tape, rates, t, y, parameters, time, state, values=(), order=P):
    """The same with series of mpmath, order after order through the whole tape."""
    with mpmath.workdps(60):
        rows = [[mpmath.mpf(float(x))] for x in state]
        for k in range(order):
            given = {x.index: row for x, row in zip(y, rows, strict=False)}
            if t is not None:
                given[t.index] = [mpmath.mpf(time), mpmath.mpf(1)]
            given |= {p.index: [mpmath.mpf(v)] for p, v in zip(parameters, values, strict=True)}
            found = evaluated(tape, rates, given, k)
            for row, rate in zip(rows, found, strict=True):
                row.append(rate[k] / (k + 1))
        return [[row[k] for row in rows] for k in range(order + 1)]


def evaluated(tape, outputs, given, k):
    """Outputs as lists of coefficients 0 ... k; each function by a recurrence written for itself."""
    table = {i: (row + [mpmath.mpf(0)] * (k + 1))[: k + 1] for i, row in given.items()}
    for i in tape.used(outputs):
        if i in table:
            continue
        code, a, b = tape.op[i], tape.a[i], tape.b[i]
        if code == CONST:
            value = tape.constants[a]
            exact = mpmath.mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else value
            table[i] = [mpmath.mpf(exact)] + [mpmath.mpf(0)] * k
            continue
        assert code != INPUT
        table[i] = _OPERATIONS[NAMES[code]](*(table[x] for x in (a, b) if x >= 0))
    return [table[x.index] if hasattr(x, "index") else [mpmath.mpf(x)] + [mpmath.mpf(0)] * k for x in outputs]


def product(a, b):
    return [mpmath.fdot(a[: k + 1], b[k::-1]) for k in range(len(a))]


def quotient(a, b):
    q = []
    for k in range(len(a)):
        q.append((a[k] - sum((q[i] * b[k - i] for i in range(k)), mpmath.mpf(0))) / b[0])
    return q


def by_taylor(function):
    """A function from its own Taylor coefficients at a_0 (mpmath differentiates it), composed with the series."""

    def operation(a, *b):
        order = len(a) - 1
        outer = mpmath.taylor(lambda x: function(x, *(z[0] for z in b)), a[0], order)
        shift = [mpmath.mpf(0), *a[1:]]
        result, power = [mpmath.mpf(0)] * (order + 1), [mpmath.mpf(1)] + [mpmath.mpf(0)] * order
        for c in outer:
            result = [r + c * p for r, p in zip(result, power, strict=True)]
            power = product(power, shift)
        return result

    return operation


def arc_tangent(y, x):
    """atan2 turned into the half-plane where it is an arctangent."""
    start = mpmath.atan2(y[0], x[0])
    s, c = mpmath.sin(start), mpmath.cos(start)
    along = [c * p + s * q for p, q in zip(x, y, strict=True)]
    across = [c * q - s * p for p, q in zip(x, y, strict=True)]
    result = by_taylor(mpmath.atan)(quotient(across, along))
    return [start, *result[1:]]


def power(a, b):
    log = by_taylor(mpmath.log)(a)
    return by_taylor(mpmath.exp)(product(b, log))


_OPERATIONS = {
    NAMES[ADD]: lambda a, b: [x + y for x, y in zip(a, b, strict=True)],
    NAMES[SUB]: lambda a, b: [x - y for x, y in zip(a, b, strict=True)],
    NAMES[MUL]: product,
    NAMES[DIV]: quotient,
    NAMES[NEG]: lambda a: [-x for x in a],
    "pow": power,
    "atan2": arc_tangent,
    **{
        name: by_taylor(getattr(mpmath, name))
        for name in (
            "sin",
            "cos",
            "tan",
            "asin",
            "acos",
            "atan",
            "sinh",
            "cosh",
            "tanh",
            "sqrt",
            "exp",
            "log",
        )
    },
}


def radius(rows):
    """Radius of convergence that the last coefficients show."""
    return min(
        (max(abs(float(x)) for x in rows[0]) / size) ** (1 / k)
        for k in range(len(rows) // 2, len(rows))
        if (size := max(abs(float(x)) for x in rows[k])) > 0
    )


def compare(found, expected, units=200):
    rho = (
        min(1.0, radius(expected))
        if any(float(x) for row in expected[len(expected) // 2 :] for x in row)
        else 1.0
    )
    scale = max(abs(float(x)) for row in expected[:2] for x in row) + 1
    for k, (mine, exact) in enumerate(zip(found, expected, strict=True)):
        error = max(abs(float(mpmath.mpf(float(x)) - y)) for x, y in zip(mine, exact, strict=True))
        assert error * rho**k <= units * EPS * scale, (k, error, rho)


# --- every recurrence --------------------------------------------------------------------------------


def turned_by(f, angle, vector):
    s, c = f.sin(angle), f.cos(angle)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]


CASES = {
    "sum": lambda f, x, y, p: (x + y, -x - 2 * y + 3),
    "product": lambda f, x, y, p: (x * y, x * x - y * x + p * y),
    "quotient": lambda f, x, y, p: (x / (y + 3), 1 / (x + 4) - p / (y + 3)),
    "quotient of products with a factor in common": lambda f, x, y, p: (
        (x * y) / (x * (y + 3)),
        (x * x) / ((y - p) * x) - x * y,
    ),
    "quotient of products with a factor in common and unlike signs": lambda f, x, y, p: (
        (x * y) / -(x * (y + 3)),
        -(x * x) / (x * (y - p)),
    ),
    "sqrt": lambda f, x, y, p: (f.sqrt(x * x + y + 4), y),
    "sin, cos": lambda f, x, y, p: (f.sin(x * y), f.cos(x) - f.sin(y)),
    "sines of sums": lambda f, x, y, p: (
        f.sin(x) * f.cos(y) + f.cos(x) * f.sin(y) - p * (f.cos(y) * f.sin(x) - f.sin(y) * f.cos(x)),
        f.sin(y) * f.cos(x) - f.cos(y) * f.sin(x) + 2 * (-f.sin(x) * f.cos(y) - f.cos(x) * f.sin(y)),
    ),
    "cosines of sums": lambda f, x, y, p: (
        f.cos(x) * f.cos(y) - f.sin(x) * f.sin(y) + p * (f.cos(y) * f.cos(x) + f.sin(y) * f.sin(x)),
        -f.cos(x) * f.cos(y) + f.sin(x) * f.sin(y) - 2 * (-f.sin(x) * f.sin(y) - f.cos(x) * f.cos(y)),
    ),
    "neither": lambda f, x, y, p: (
        f.sin(x) * f.cos(y) + f.sin(x) * f.sin(y),
        f.cos(x) * f.cos(x) - f.sin(x) * f.sin(x) + f.sin(x) * f.cos(2 * x) - f.cos(x) * f.sin(y),
    ),
    "a sum of three angles": lambda f, x, y, p: turned_by(f, y, turned_by(f, x + y, turned_by(f, x, (1, 0)))),
    "factors in common": lambda f, x, y, p: (
        x * f.sin(y) - p * (x * f.cos(y)) + 3 * x * y,
        (p * x) * f.sin(y)
        - x * (p * f.sin(y))
        + 2 * (x * f.apply("exp", y))
        - y * x * 0.5
        + f.apply("exp", y) * y,
    ),
    "tan": lambda f, x, y, p: (f.apply("tan", x / 2), y),
    "exp, log": lambda f, x, y, p: (f.apply("exp", -x), f.apply("log", y + 3)),
    "asin, acos": lambda f, x, y, p: (f.apply("asin", x / 3), f.apply("acos", y / 3)),
    "atan": lambda f, x, y, p: (f.apply("atan", x), y / 3),
    "sinh, cosh": lambda f, x, y, p: (f.apply("sinh", x) - f.apply("cosh", y), f.apply("cosh", x)),
    "tanh": lambda f, x, y, p: (f.apply("tanh", x), -y),
    "atan2": lambda f, x, y, p: (f.apply("atan2", x, y), f.apply("atan2", y, p)),
    "atan2 of a number": lambda f, x, y, p: (f.apply("atan2", p, x + 2), y),
    "power": lambda f, x, y, p: ((x + 3) ** 0.3, (y + 3) ** p),
    "power of a series": lambda f, x, y, p: (f.apply("pow", x + 3, y), f.apply("pow", p, x)),
    "nested": lambda f, x, y, p: (f.sin(f.cos(x) * y) / (2 + f.sin(y)), f.sqrt(2 + f.sin(x + y)) * p),
    "numbers": lambda f, x, y, p: (3, p),
}


assert jet.PIECE == jet_of_lanes.PIECE
WAYS = [*((name, jet.PIECE) for name in CASES), *sampled(((name, 1) for name in CASES), 4)]
"""In one block, and cut into pieces."""


@pytest.mark.parametrize(("name", "piece"), WAYS)
def test_recurrence(name, piece, monkeypatch):
    """In one block and cut into pieces."""
    monkeypatch.setattr(jet.jet, "__defaults__", (piece,))
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    tape = Tape()
    t, x, y, p = (tape.input(n) for n in ("t", "x", "y", "p"))
    rates = list(CASES[name](tape, x, y, p))
    arguments = (tape, rates, t, [x, y], [p], 0.3, [0.7, -0.4], [1.3])
    compare(coefficients(*arguments), reference(*arguments))


def test_time_and_a_coordinate_that_no_rate_needs():
    tape = Tape()
    t, x, y = (tape.input(n) for n in ("t", "x", "y"))
    arguments = (tape, [tape.sin(3 * t) * x, t * t], t, [x, y], [], 0.9, [0.7, 5.0])
    found = coefficients(*arguments)
    compare(found, reference(*arguments))
    assert found[:5, 1] == pytest.approx([5, 0.81, 0.9, 1 / 3, 0], abs=4 * EPS)


def test_a_known_solution():
    """x' = 1 + x²: tan; its coefficients are rational."""
    tape = Tape()
    x = tape.input("x")
    found = coefficients(tape, [x * x + 1], None, [x], [], 0.0, [0.0])[:, 0]
    tangent = [Fraction(0)]
    for k in range(P):
        tangent.append((sum((tangent[i] * tangent[k - i] for i in range(k + 1)), Fraction(k == 0))) / (k + 1))
    assert found == pytest.approx([float(x) for x in tangent], rel=P * EPS, abs=0)


def test_a_factor_in_common_is_left_out_of_a_quotient():
    """(x y) / (x (y + 3)) = y / (y + 3): one sum of products, that of the quotient."""
    tape = Tape()
    x, y = tape.input("x"), tape.input("y")
    rates = [(x * y) / (x * (y + 3)), x]
    recurrence = shortened(Recurrence(lower(tape, {"series": rates}, None, [x, y], []), "series"))
    kept = [recurrence.nodes[i] for i in recurrence.order]
    assert [node.rule for node in kept if node.products or node.rule == "quotient"] == ["quotient"]


def products_of(rates, state, parameters=()):
    """How many products of series their recurrence takes."""
    tape = next(x.tape for x in rates if isinstance(x, Traced))
    recurrence = shortened(
        Recurrence(lower(tape, {"series": rates}, None, state, list(parameters)), "series")
    )
    nodes = [recurrence.nodes[i] for i in recurrence.order]
    return sum(len(node.products) + (node.rule in ("quotient", "root")) for node in nodes)


def test_the_sine_of_a_sum_takes_one_product():
    """(cos (x + y + z), sin (x + y + z)) by three rotations: as many products as by the sum."""
    tape = Tape()
    x, y, z = state = [tape.input(name) for name in "xyz"]
    tip = turned_by(tape, x, turned_by(tape, y, turned_by(tape, z, (1, 0))))
    assert (
        products_of([*tip, x], state)
        == products_of([tape.cos(x + y + z), tape.sin(x + y + z), x], state)
        == 2
    )


def test_a_factor_in_common_is_drawn_out_of_a_sum():
    """p x y + 2 x z - x² = x (p y + 2 z - x), and what cancels is gone."""
    tape = Tape()
    x, y, z, p = (tape.input(name) for name in "xyzp")
    assert products_of([p * (x * y) + 2 * x * z - x * x, y, z], [x, y, z], [p]) == 1
    assert products_of([(p * x) * y - x * (p * y) + z, y, z], [x, y, z], [p]) == 0
    shared = x * y
    assert products_of([shared + x * z, shared, z], [x, y, z]) == 2  # x y is needed anyway


def test_a_rotation_there_and_back_is_left_out():
    """R (p Rᵀ v + w) = p v + R w."""
    tape = Tape()
    x, y, z, p = (tape.input(name) for name in "xyzp")

    s, c, u, v = tape.sin(x), tape.cos(x), x * x, y * y
    across, along = p * (c * u + s * v) + z, p * (c * v - s * u) + 3 * z
    found = [c * across - s * along, s * across + c * along, z]
    by_hand = [p * u + (c - 3 * s) * z, p * v + (s + 3 * c) * z, z]
    assert products_of(found, [x, y, z], [p]) == products_of(by_hand, [x, y, z], [p]) == 6
    arguments = (tape, found, None, [x, y, z], [p], 0.3, [0.7, -0.4, 0.2], [1.3])
    compare(coefficients(*arguments), reference(*arguments))


def test_sums_of_sums_are_sums_of_what_these_are_made_of():
    """p (x + y) - p x + 2 q (x + y) = 2 q x + (p + 2 q) y; of what cancels nothing is left, numbers that stand alone
    stay, and no sum gets more terms than it had."""
    tape = Tape()
    x, y, z, p, q = (tape.input(name) for name in "xyzpq")
    both = x + y + 1
    state, parameters = [x, y, z], [p, q]
    rates = [p * both - p * x + 2 * q * both, p * both - q * (p * x) - p * y, both * z - (x - y + z) * 3]
    recurrence = shortened(Recurrence(lower(tape, {"series": rates}, None, state, parameters), "series"))
    combined(recurrence)
    terms = [recurrence.nodes[i].terms for i in recurrence.outputs]
    assert [len(found) for found in terms[:2]] == [3, 2]  # x, y and a number; x and a number
    assert [recurrence.nodes[i].operand for _, i in terms[1] if isinstance(i, int)] == [
        i for i in recurrence.order if recurrence.nodes[i] == Node("state", 0)
    ]
    arguments = (tape, rates, None, state, parameters, 0.3, [0.7, -0.4, 0.2], [1.3, 0.6])
    compare(coefficients(*arguments), reference(*arguments))


def test_nothing_is_multiplied_by_a_reciprocal():
    """Three quotients by one divisor are three sums of products; where 1 / d is wanted itself, it stays."""
    tape = Tape()
    x, y, z = state = [tape.input(name) for name in "xyz"]
    d = y + 3
    assert products_of([x / d, z / d - x, y / d], state) == 3
    assert products_of([x / d, 1 / d, z], state) == 2
    arguments = (tape, [x / d, z / d - x, 1 / (x + 4) + y / d], None, state, [], 0.0, [0.7, -0.4, 0.2])
    compare(coefficients(*arguments), reference(*arguments))


def test_products_of_a_heavy_top():
    """Of Euler's angles, no more than by hand."""
    s = fb.System("top")
    s.parameters(m=1, R=0.1, L=0.2)
    s.gravity = (0, 0, -9.81)
    rotor = s.body("rotor", fb.disk("m", "R", axis="z"))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, "-L"), axis="ZXZ", coordinate=["psi", "theta", "phi"])
    _, rates, _, state, parameters = rates_of(assemble(s))
    assert products_of(rates, state, parameters) == 9


@pytest.mark.parametrize("function", ["abs", "sign", "min", "max"])
def test_what_bends_is_refused(function):
    tape = Tape()
    x = tape.input("x")
    bent = tape.apply(function, x, 2 * x) if function in ("min", "max") else tape.apply(function, x)
    with pytest.raises(ExpressionError, match=f"'{function}' has no Taylor series where it bends"):
        coefficients(tape, [bent], None, [x], [], 0.0, [1.0])


def test_of_a_number_nothing_is_refused():
    """|p| is a number along the motion."""
    tape = Tape()
    x, p = tape.input("x"), tape.input("p")
    found = coefficients(tape, [abs(p) * x], None, [x], [p], 0.0, [1.0], [-2.0])[:, 0]
    assert found == pytest.approx([2.0**k / math.factorial(k) for k in range(P + 1)], rel=P * EPS)


# --- machines ----------------------------------------------------------------------------------------


def rates_of(model):
    """(tape, rates, time, state, parameters) of a model without constraints."""
    tape = Tape()
    state = traced_state(model, tape)
    rates = [*coordinate_rates(model, state), *motion(model, state).udot]
    return tape, rates, state.t, [*state.q, *state.u], [state.values[p.symbol] for p in model.parameters]


@pytest.mark.parametrize("joint", [j for j in JOINTS if j != "weld"])
def test_random_machines(joint):
    """Every joint, with springs, dampers, forces and couples."""
    model = assemble(random_system(7, 1, (joint,)))
    q, u = random_state(model, 3)
    arguments = (*rates_of(model), 0.4, [*q, *u], list(model.values().values()))
    compare(coefficients(*arguments)[:7], reference(*arguments, order=6), units=2000)


def test_a_recurrence_in_pieces_is_the_same(monkeypatch):
    """In one block and cut up, where sums are added in another order."""
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    model = assemble(random_system(5, 2, ("hinge", "universal")))
    tape, rates, t, y, parameters = rates_of(model)
    program = lower(tape, {"series": rates}, t, y, parameters)
    assert 100 < len(shortened(Recurrence(program, "series")).order) < 2 * jet.PIECE
    q, u = random_state(model, 3)
    arguments = (tape, rates, t, y, parameters, 0.4, [*q, *u], list(model.values().values()))
    whole = coefficients(*arguments)
    monkeypatch.setattr(jet.jet, "__defaults__", (30,))
    compare(coefficients(*arguments), whole, units=2000)


# --- eight motions at once -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "piece"), [*sampled(((name, jet.PIECE) for name in CASES), 3), *WAYS[len(CASES) :]]
)
def test_recurrence_of_eight(name, piece, monkeypatch):
    """Each motion has its own time, state and parameter; in one block and cut into pieces."""
    monkeypatch.setattr(jet_of_lanes.jet_of_lanes, "__defaults__", (piece,))
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    tape = Tape()
    t, x, y, p = (tape.input(n) for n in ("t", "x", "y", "p"))
    rates = list(CASES[name](tape, x, y, p))
    times, values = np.linspace(0, 0.7, 8), np.linspace(0.8, 1.5, 8)[:, None]
    states = np.stack([np.linspace(0.3, 1, 8), np.linspace(-0.6, -0.3, 8)], axis=1)
    found = coefficients_of_eight(tape, rates, t, [x, y], [p], times, states, values)
    alone = series(tape, rates, t, [x, y], [p])
    for k in range(8):
        compare(found[k], alone(times[k], states[k], values[k]), units=400)
    compare(found[5], reference(tape, rates, t, [x, y], [p], times[5], states[5], values[5]))


@pytest.mark.parametrize("joint", [j for j in JOINTS if j != "weld"])
def test_random_machines_of_eight(joint):
    """More products than fit side by side; a motion is the same to the last bit in any place and company."""
    model = assemble(random_system(7, 1, (joint,)))
    given = rates_of(model)
    states = np.array([np.concatenate(random_state(model, seed)) for seed in range(8)])
    times, values = np.linspace(0, 0.7, 8), np.tile(list(model.values().values()), (8, 1))
    found = coefficients_of_eight(*given, times, states, values)
    alone = series(*given)
    for k in range(8):
        compare(found[k][:7], alone(times[k], states[k], values[k])[:7], units=2000)
    turned = coefficients_of_eight(*given, times[::-1], states[::-1], values)
    assert np.array_equal(found, turned[::-1])
    states[[0, 3]] = np.nan
    assert np.array_equal(found[1], coefficients_of_eight(*given, times, states, values)[1])


def test_the_loop_knows_the_order():
    assert ORDERS["taylor"] == jet.ORDER
