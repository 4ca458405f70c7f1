"""No formula ends the interpreter: what would be too long is refused, or written another way."""

import re
import subprocess
import sys
import time

import pytest
import sympy

import freebody as fb
from freebody.cli import main
from freebody.errors import ModelError, TooManyTermsError
from freebody.scalar.budget import FREE, SLOW, WORK
from freebody.scalar.polynomial import Ring

MEMORY = 3 * 2**30
"""Bytes of address space that each of these may take."""

t = sympy.Symbol("t")
q = [sympy.Function(f"q{i}")(t) for i in range(60)]
p = sympy.symbols("p0:60")
squares = sum(sympy.sin(x) ** 2 for x in q[:41])

LONG = {
    "sine of 41 squares of sines": sympy.sin(squares, evaluate=False),
    "cosine of a sum of 30 angles": sympy.cos(sum(q[:30]), evaluate=False),
    "power of a sum of sines": squares**20,
    "power of a sum": sum(p[:26]) ** 100,
    "power of a binomial": (p[0] + 1) ** 10**6,
    "square of a product of sines": sympy.Mul(*[sympy.sin(x) for x in q[:41]]) ** 2,
    "product of cosines of sums": sympy.Mul(*[sympy.cos(sum(q[i : i + 4])) for i in range(40)]),
    "power of roots": sum(sympy.sqrt(sum(p[i : i + 10])) for i in range(20)) ** 20,
    "powers of an inverse": p[25] ** 20 / sum(p[:26]) ** 20,
    "exponentials": sum(sympy.exp(x) for x in p) ** 30,
    "multiples of angles": sympy.sin(24 * sum(q[:6]), evaluate=False),
    "cosine of arc cosines": sympy.cos(sum(sympy.acos(x) for x in p[:30]), evaluate=False),
}


def chain(links, springs=False, **last):
    """A plane chain of bars in relative angles."""
    s = fb.System("chain")
    g, m, L, k = s.parameters(g=9.81, m=1.0, L=0.3, k=1.0)
    s.gravity = (0, -g, 0)
    parent, at = s.ground, (0, 0, 0)
    for i in range(1, links + 1):
        bar = s.body(f"link{i}", fb.slender_bar(m, L, axis="y"))
        pin = s.hinge(f"pin{i}", parent, bar, at=at, to=(0, L / 2, 0), axis="z", coordinate=f"theta{i}")
        if springs:
            s.spring(f"spring{i}", pin, stiffness=k)
        parent, at = bar, (0, -L / 2, 0)
    return s


def limited(code):
    """What a Python process with little memory prints; it has to come to its end."""
    head = f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY}))\n"
    head += "import sys; sys.path[:0] = sys.argv[1:]\n"
    folder = __file__.rsplit("/", 1)[0]
    done = subprocess.run(
        [sys.executable, "-c", head + code, folder, *sys.path], capture_output=True, text=True, timeout=240
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


def test_long_expressions_are_refused_and_the_interpreter_lives():
    said = limited(
        "import test_budget as b\n"
        "for name, x in b.LONG.items():\n"
        "    try: b.Ring().from_sympy(x); print(name, 'was formed')\n"
        "    except b.TooManyTermsError as error: print('refused:', error)\n"
    )
    lines = said.splitlines()
    assert len(lines) == len(LONG)
    assert all(line.startswith("refused: Expected an expression to need") for line in lines), said


def test_a_determinant_of_symbols_is_refused():
    ring = Ring()
    M = [[ring.generator(sympy.Symbol(f"m{i}_{j}")) for j in range(12)] for i in range(12)]
    memo = {}

    def determinant(row, columns):
        if not columns:
            return 1
        if columns not in memo:
            memo[columns] = sum(
                (-1) ** s * M[row][c] * determinant(row + 1, columns[:s] + columns[s + 1 :])
                for s, c in enumerate(columns)
            )
        return memo[columns]

    with pytest.raises(TooManyTermsError, match="terms"):
        determinant(0, tuple(range(12)))


def test_work_of_one_question_is_bounded_and_the_next_has_its_own():
    ring = Ring()
    refused = pytest.raises(TooManyTermsError, match="Expected a test to need at most .* Stop.$")
    with ring.budget.question("a test", "Stop."), refused:
        for _ in range(10):
            ring.budget.scan(WORK // SLOW // 4)
    with ring.budget.question("another"):
        ring.budget.scan(WORK // SLOW // 4)


def test_a_question_inside_is_no_dearer():
    ring = Ring()
    a = ring.from_sympy(sum(p[:40]))
    with ring.budget.question("outer", "Ask less.", terms=500), ring.budget.question("inner", "No."):
        assert ring.budget.most == 500
        with pytest.raises(TooManyTermsError) as refused:
            a**9
    # the narrower name, and the cure of what was asked for at first
    assert "Expected inner to need" in str(refused.value)
    assert str(refused.value).endswith("Ask less.")
    assert len(a * a) == 820 > 500  # outside, and below what is free anyway
    assert FREE > 820


def test_estimates_do_not_refuse_what_is_short():
    """(a + b)^n has n + 1 terms, x^n - 1 over x - 1 has n, though more would fit their degrees."""
    ring = Ring()
    a, b = ring.generator(p[0]), ring.generator(p[1])
    assert len((a + b) ** 300) == 301
    assert len((a**400 - 1) / (a - 1)) == 400
    # a divisor that does not divide is an inverse, without a long remainder on the way
    x = a**100 / ring.from_sympy(sum(p[:30]) + 1)
    assert len(x) == 1


def test_long_divisions_in_turns_give_the_same_remainder(monkeypatch):
    from freebody.scalar import relations

    def value(step):
        monkeypatch.setattr(relations, "STEP", step)
        ring = Ring()
        i = ring.from_sympy(1 / (p[0] + p[1] + p[2] + 1))
        x = ring.from_sympy((p[0] + 2 * p[1] + q[0]) ** 3)
        return str(i**3 * x + i * x * x), str((2 * i) ** 2 * x)

    whole = value(2**22)
    assert value(64) == whole  # some terms at a time
    assert value(1) == whole  # one leading monomial at a time


@pytest.mark.parametrize("links", [20, pytest.param(100, marks=pytest.mark.slow)])
def test_equations_of_a_chain_are_printed_in_seconds(links):
    begun = time.perf_counter()
    text = fb.equations(chain(links)).text()
    assert time.perf_counter() - begun < 60  # 3 s for 100 links on a quiet machine
    lines = text.splitlines()
    assert max(map(len, lines)) < 250
    # a line for the angle, two for the motion, three for the force of each link, one equation
    assert len(lines) == 7 * links - 2 - 3 + 4
    assert f"  phi_link{links} = theta{links} + phi_link{links - 1}" in lines


def test_length_of_recursive_equations_is_linear_in_the_links():
    sizes = [len(fb.equations(chain(n), form="recursive").text()) for n in (10, 20, 30)]
    assert abs((sizes[2] - sizes[1]) - (sizes[1] - sizes[0])) < sizes[0] / 20


REFUSED = ["e(s).motion", "fb.steady_motions(s)", "e(s).free_body('link3').text()"]
REFUSED_TOO = [
    "e(s).mass_matrix",
    "e(s).reactions['pin1']",
    "e(s).energy.text()",
    "e(s).momentum.text()",
    "e(s).integrals",
    "e(s).routh()",
    "e(s).planar",
    "e(s).solve('pin1_x')",
    "e(s).eliminate('pin1')",
    "e(s, form='explicit').text()",
    "fb.impulse(s, at=s.bodies['link1'].origin, impulse=(1, 0, 0)).text()",
    "fb.free_body_diagram(s, 'link2')",
]


@pytest.mark.parametrize(
    "asked", [REFUSED[:1], pytest.param([*REFUSED[1:], *REFUSED_TOO], marks=pytest.mark.slow)]
)
def test_what_a_chain_of_20_links_cannot_say_is_refused_and_the_interpreter_lives(asked):
    said = limited(
        "import freebody as fb, test_budget as b\n"
        "s = b.chain(20)\n"
        "e = fb.equations\n"
        f"asked = [{', '.join(f'lambda: {one}' for one in asked)}]\n"
        "for one in asked:\n"
        "    try: one(); print('formed')\n"
        "    except fb.FreebodyError as error: print(type(error).__name__, error)\n"
        "print(len(fb.draw(s).svg))\n"
    )
    *lines, drawn = said.splitlines()
    assert len(lines) == len(asked)
    assert all(line.startswith("TooManyTermsError Expected ") for line in lines), said
    assert all("'chain'" in line for line in lines)
    cure = ["near={...}" if "steady" in one else "form='recursive'" for one in asked]
    assert all(word in line for word, line in zip(cure, lines, strict=True)), said
    assert int(drawn) > 1000


def test_definitions_are_sympy_expressions_in_order():
    e = fb.equations(chain(3), form="recursive")
    known = set(e.coordinates) | {parameter.symbol for parameter in e.model.parameters}
    for symbol, value in e.definitions.items():
        atoms = value.free_symbols - {e.model.names.atoms["t"]}
        assert atoms | value.atoms(sympy.core.function.AppliedUndef) <= known, symbol
        known.add(symbol)
    assert len(e.motion) == 3
    # put into each other they are the equations
    whole = fb.equations(chain(3))
    for short, (left, right) in zip(e.motion, whole.balances, strict=True):
        x = short.lhs
        for symbol, value in reversed(e.definitions.items()):
            x = x.subs(symbol, value).doit()
        assert whole.ring.from_sympy(x) == left - right
    assert fb.equations(chain(3)).definitions == {}


def test_form_of_equations_is_checked():
    with pytest.raises(ModelError, match="Unknown form 'recursiv' of equations; did you mean 'recursive'"):
        fb.equations(chain(2), form="recursiv")


def test_all_prints_have_the_same_lines():
    e = fb.equations(chain(3), form="recursive")
    n = len(e.text().splitlines())
    assert len(e.latex().splitlines()) == n + 2
    assert e.html().count("data-tex") == n
    assert r"\ddot{\phi}_{link2}" in e.latex().replace(r"\mathrm", "") or "phi" in e.latex()


@pytest.mark.slow
def test_four_elastic_links_are_handed_over_to_numbers():
    found = fb.steady_motions(chain(4, springs=True), values={})
    assert "Expected the steady motions in closed form to need no expression of more than" in found.reason
    assert "In numbers:" in found.text()
    assert len(found.states) > 1
    assert max(one.residual for one in found.states) < 1e-12
    assert any(all(abs(x) < 1e-9 for x in one.values.values()) for one in found.states)  # it hangs straight


def test_a_steady_motion_near_a_guess():
    s = chain(20)
    found = fb.steady_motions(s, values={})
    assert "too long" not in found.text() and found.reason.startswith(
        "Expected the equations of motion of 'chain'"
    )
    assert "others may exist" in found.text()
    assert found.states[0].stability.verdict == "stable"
    upright = fb.steady_motions(s, values={}, near={"theta1": 3})[0]
    assert upright.values["theta1"] == pytest.approx(sympy.pi.evalf(), abs=1e-12)
    assert upright.stability.verdict == "unstable"


def test_steady_motion_near_a_guess_agrees_with_the_closed_form():
    s = fb.System("pendulum")
    m, L, g, k = s.parameters(m=1, L=0.5, g=9.81, k=2.0)
    s.gravity = (0, -g, 0)
    bob = s.body("bob", fb.particle(m))
    pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    s.spring("spring", pin, stiffness=k, rest=1)
    everything = fb.steady_motions(s, values={}).states
    (near,) = fb.steady_motions(s, values={}, near={"theta": 0.2}).states
    assert any(abs(near.values["theta"] - one.values["theta"]) < 1e-12 for one in everything)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"near": {"thetta1": 1}}, "Unknown coordinate 'thetta1' in near; did you mean"),
        ({"near": {"theta1": "up"}}, "Expected a number for 'theta1' in near, got 'up'."),
        ({"near": {}, "values": {"theta1": 1}}, "Give coordinates by near="),
    ],
)
def test_messages_about_a_guess(arguments, message):
    with pytest.raises(ModelError) as refused:
        fb.steady_motions(chain(2), **arguments)
    assert message in str(refused.value)


def test_no_equilibrium_near_a_guess_is_said():
    s = fb.System("falling")
    s.gravity = (0, -9.81, 0)
    s.slider("guide", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
    with pytest.raises(ModelError, match=r"No equilibrium of 'falling' found from \{'y': 0.0\}.* Give near="):
        fb.steady_motions(s, near={})


def test_constraints_have_no_motion_near_a_guess():
    s = chain(2)
    s.constrain("theta1 + theta2")
    with pytest.raises(ModelError, match="Expected a tree of joints without constraints"):
        fb.steady_motions(s, near={})


def test_the_commands_speak_of_a_long_chain(tmp_path, capsys):
    path = str(tmp_path / "chain.toml")
    fb.write(chain(14), path)

    def said(*arguments):
        with pytest.raises(SystemExit) as ended:
            main([*arguments])
        shown = capsys.readouterr()
        return ended.value.code or 0, shown.out + shown.err

    code, text = said("check", path)
    assert code == 0
    assert re.search(r"Equations of motion: up to \S+ terms written out; printed recursively\.", text)
    code, text = said("analyze", path)
    assert code == 0
    assert "need no expression of more than" in text
    assert "next to zero; others may exist" in text
    assert "Frequencies in rad/s" in text
    code, text = said("equations", path, "--form", "explicit")
    assert code == 2
    assert "form='recursive'" in text


def test_a_parameter_that_is_too_long_is_named_and_the_machine_moves():
    s = fb.System("block")
    s.parameters(m=1.0, L=1.0, g=9.81)
    mass = "(m+L+g+1)^60*(g+m+2)^60/(m+L+g+1)^60/(g+m+2)^60 + (m+L+g+1)^60*(m+g+3)^50/1e120"
    s.slider("guide", s.ground, s.body("block", fb.particle(mass)), axis="x", coordinate="x")
    s.force("push", s.bodies["block"], (1, 0, 0))
    with pytest.raises(
        TooManyTermsError, match=r"In .*\*\*60.*: Expected .*Give it a name: make it a parameter of its own"
    ):
        fb.equations(s).text()
    assert fb.simulate(s, 1).status == "finished"
