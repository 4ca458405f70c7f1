"""Laws of round shapes on lines of heights: rates, accelerations and formulas of the foot, and forces in balance."""

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state, polynomial_state
from freebody.dynamics.conditions.contact import contact_rows, row_of, touches, unit_forces
from freebody.dynamics.kinematics import state_along
from freebody.scalar.algebra import floats
from freebody.scalar.polynomial import Ring
from freebody.scalar.series import derivative_at_start
from freebody.scalar.substitute import Substitution

EPS = np.finfo(float).eps


@pytest.mark.parametrize("kind", ["circle", "sphere"])
def test_a_round_shape_on_a_heightline(kind):
    """On the line at distance R of y = f(x), ġ = g̈ = 0 along motions; formulas, series and differences agree."""
    s = fb.System("hill")
    wheel = s.body("wheel", fb.disk(2, 0.3))
    s.parameters(a=0.4, k=2, R=0.3)
    s.planar("p", s.ground, wheel, coordinate="x y f")
    shape = wheel.circle("R") if kind == "circle" else wheel.sphere("R")
    s.contact("hill", s.ground.heightline("a*sin(k*x)", at=(0.1, 0.2, 0)), shape, friction=0.3)
    model = fb.assemble(s)
    p, v = 0.5, 1.3

    def centre(p):
        f, slope = 0.4 * np.sin(2 * p), 0.8 * np.cos(2 * p)
        w = np.sqrt(1 + slope**2)
        return np.array([0.1 + p - 0.3 * slope / w, 0.2 + f + 0.3 / w])

    h = 1e-4
    before, now, after = (centre(p + k * h) for k in (-1, 0, 1))
    speed, change = v * (after - before) / (2 * h), v**2 * (after - 2 * now + before) / h**2
    state = float_state(model, [*now, 0.2], [*speed, 0.4])
    rows = contact_rows(model, state)
    assert rows.gap[0] == pytest.approx(0, abs=EPS)
    assert rows.rate[0] == pytest.approx(0, abs=1e-7)
    acceleration = np.dot(rows.matrix[0], [*change, 0]) + rows.bias[0]
    assert acceleration == pytest.approx(0, abs=1e-6)
    values = {"a": 0.4, "k": 2, "R": 0.3}
    ring = Ring()
    formulas = contact_rows(model, polynomial_state(model, ring))
    atoms = {c.symbol: float(x) for c, x in zip(model.coordinates, [*now, 0.2], strict=True)}
    atoms |= {u.symbol: float(x) for u, x in zip(model.speeds, [*speed, 0.4], strict=True)}
    atoms |= {q.symbol: values[q.name] for q in model.parameters}
    number = Substitution(ring, floats, atoms)
    for ours, theirs in ((rows.gap, formulas.gap), (rows.rate, formulas.rate), (rows.bias, formulas.bias)):
        assert [number(x) for x in theirs] == pytest.approx(list(map(float, ours)), rel=1e-12, abs=1e-12)
    # the derivative of the gap as a formula is the row of the contact, on the line
    slopes = [number(ring.derivative(formulas.gap[0], c.symbol)) for c in model.coordinates]
    assert slopes == pytest.approx(list(map(float, rows.matrix[0])), abs=1e-12)


def test_equations_have_the_foot_as_a_symbol_with_its_equation():
    """N at rest is the share of the weight along the normal."""
    s = fb.System("wheel")
    s.gravity = (0, -9.81, 0)
    wheel = s.body("wheel", fb.disk(2, 0.2))
    s.planar("p", s.ground, wheel, coordinate="x y f")
    s.contact("road", wheel.circle(0.2), s.ground.heightline("x^2"), friction=0.6)
    equations = fb.equations(s, modes={"road": "stick"})
    assert len(equations.constraints) == 3 and "x_road" in str(equations.constraints[-1])
    N = equations.solve("N_road", where={"x'": 0, "y'": 0, "f'": 0})["N_road"]
    at = {str(symbol): symbol for symbol in N.free_symbols}
    assert float(N.subs(at["x_road"], 0.3)) == pytest.approx(2 * 9.81 / np.hypot(1, 0.6))


def test_the_far_side_of_an_end_is_told():
    """``reach`` is what the centre lacks to the ends, above which the foot is in the line."""
    s = fb.System("kerb")
    wheel = s.body("wheel", fb.disk(1, 0.2))
    s.planar("p", s.ground, wheel, coordinate="x y f")
    line = s.ground.heightline("0.3*x", between=(-1, 2))
    s.contact("kerb", wheel.circle(0.2), line)
    s.contact("foot", wheel.origin, line)
    model = fb.assemble(s)
    assert [c.name for c in model.contacts] == ["kerb", "kerb_start", "kerb_end", "foot"]
    shift = 0.2 * 0.3 / np.hypot(1, 0.3)
    for x in (-1.5, 0.5, 2.5):
        state = float_state(model, [x, 3, 0.1])
        kerb, start, end, foot = touches(model, state)
        assert kerb.reach == pytest.approx((x + shift + 1, 2 - x - shift), abs=4 * EPS)
        assert foot.reach == pytest.approx((x + 1, 2 - x), abs=4 * EPS)
        assert start.gap == pytest.approx(np.hypot(x + 1, 3 + 0.3) - 0.2)
        assert end.gap == pytest.approx(np.hypot(x - 2, 3 - 0.6) - 0.2)


def test_a_line_that_moves_and_turns():
    """On a line of a body the forces on both bodies are in balance, and gaps change at the rate of their series."""
    s = fb.System("cam")
    cam, wheel = s.body("cam", fb.disk(2, 0.5)), s.body("wheel", fb.disk(1, 0.2))
    s.planar("c", s.ground, cam, coordinate="x y f")
    s.planar("w", s.ground, wheel, coordinate="x1 y1 f1")
    s.contact("road", wheel.circle(0.2), cam.heightline("0.1*cos(3*x)", at=(0, 0.1, 0)), friction=0.5)
    model = fb.assemble(s)
    state = float_state(model, [0.1, 0.2, 0.3, 0.4, 0.6, 0.5], [0.3, -0.2, 0.7, 0.1, 0.4, -0.6])
    contact = model.contacts[0]
    for row in unit_forces(model, state, contact):
        total = np.array(row_of(model, state, row, contact), float)
        assert total[:2] + total[3:5] == pytest.approx(0, abs=8 * EPS)
    along = touches(model, state_along(model, state, state.u, 1, 2))[0]
    later = touches(model, float_state(model, [a + 1e-6 * b for a, b in zip(state.q, state.u, strict=True)]))[
        0
    ]
    assert (later.gap - touches(model, state)[0].gap) / 1e-6 == pytest.approx(
        float(derivative_at_start(along.gap)), rel=1e-5
    )
