"""Section 6.9: rotation about a fixed point, gyroscopes, (6.85)-(6.106)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos

import freebody as fb

from ..gallery.tools.case import mass_properties
from . import machines
from .meaning import Meaning
from .momentum import angular_momentum, resolved, vector
from .small import Small, put
from .statement import Statement

t = machines.t
theta_0 = sympy.Symbol("theta_0", real=True)
rate_0 = sympy.Symbol("psi_0'", real=True)
POSITIVE = {n: sympy.Symbol(n, positive=True) for n in ("m", "L", "g", "I_xi", "I_zeta", "Omega_zeta")}


def own(x: Any) -> Any:
    """Return an expression of the gyroscope in symbols declared positive, so that roots of them simplify."""
    atoms = machines.gyroscope().atoms
    named = {atoms[n]: positive for n, positive in POSITIVE.items()}
    return x.xreplace(named) if isinstance(x, sympy.MatrixBase) else sympy.sympify(x).xreplace(named)


@cache
def top() -> Meaning:
    """The gyroscope by the library: vectors in ground axes, components along ξηζ, and the moment its motion requires.

    ω of the axes follows from the rates of their unit vectors, H_ξ, H_η, H_ζ from the moments of inertia about 0 and
    the angular velocity, M_ξ, M_η, M_ζ from the free body resolved along the axes. The vectors do not use these
    components.
    """
    machine = machines.gyroscope()
    a, origin = machine.atoms, machine.system.ground.origin
    units = machine.units("axes")
    weight = machine.free_body("rotor", about=origin).moments["weight"]
    along = machine.free_body("rotor", about=origin, frame=machine.body("axes")).moments["weight"]
    _, required = machine.balances("rotor", about=origin, frame=machine.body("axes"))
    frame = [units[(i + 1) % 3].diff(t).dot(units[(i + 2) % 3]) for i in range(3)]
    body = machine.omega("rotor")
    spin = [body.dot(u) for u in units]
    inertia = mass_properties(machine.body("rotor")).about((0, 0, -a["L"]))
    vectors = {"ω": machine.omega("axes"), "Ω": body, "H_0": machine.momentum(), "M_0": sympy.Matrix(weight)}
    names = {
        **machine.names, **vectors, **resolved("i j k", units), **resolved("ω_ξ ω_η ω_ζ", frame),
        **resolved("Ω_ξ Ω_η Ω_ζ", spin), **resolved("H_ξ H_η H_ζ", angular_momentum(inertia, spin)),
        **resolved("M_ξ M_η M_ζ", along), **resolved("A_ξ A_η A_ζ", required), "I_η": a["I_xi"],
    }  # fmt: skip
    return Meaning(
        {name: own(x) for name, x in names.items()}, along=[(k, own(v)) for k, v in machine.along()]
    )


def rows() -> list[tuple[Any, Any]]:
    """Return (rate of the angular momentum, moment of the weight) about 0 along ξ, η, ζ."""
    names = top().names
    return [(names[f"A_{c}"], names[f"M_{c}"]) for c in "ξηζ"]


def _modified() -> Meaning:
    """M along ξηζ is the moment that the motion requires; the library resolves H from ground axes."""
    names = top().names
    units = [names[c] for c in "ijk"]
    moments = {f"M_{c}": names[f"A_{c}"] for c in "ξηζ"}
    return Meaning({**names, **moments, **resolved("H_ξ H_η H_ζ", [names["H_0"].dot(u) for u in units])})


def _moment() -> Meaning:
    """The moment that a motion requires, in ground axes and along ξηζ; the moment of the weight has one component."""
    machine, names = machines.gyroscope(), top().names
    _, moment = machine.balances("rotor", about=machine.system.ground.origin)
    return Meaning({**names, "M_0": own(moment), **{f"M_{c}": names[f"A_{c}"] for c in "ξηζ"}})


def _momentum() -> Meaning:
    names = top().names
    return Meaning({**names, **resolved("H_ξ H_η H_ζ", [names["H_0"].dot(names[c]) for c in "ijk"])})


def _explicit() -> Meaning:
    """The library's modified Euler equations of a body of revolution."""
    I_xi, I_zeta = sympy.symbols("I_xi I_zeta", real=True)
    rates = [sympy.Function(f"omega_{g}")(t) for g in ("xi", "eta", "zeta")]
    return Meaning({
        "I_ξ": I_xi, "I_ζ": I_zeta, **resolved("ω_ξ ω_η ω_ζ", rates), "Ω_ζ": sympy.Function("Omega_zeta")(t),
        **resolved("M_ξ M_η M_ζ", fb.forms.modified_euler_equations()),
    })  # fmt: skip


def _balances() -> Meaning:
    return Meaning(top().names, rows=dict(enumerate(rows())))


# --- steady precession ------------------------------------------------------------------------------------------


@cache
def precession() -> Any:
    """Steady motions of the gyroscope by the library."""
    return fb.steady_motions(machines.gyroscope().system, terms={"Omega_zeta": "phi' + psi'*cos(theta)"})


def at_steady(x: Any) -> Any:
    """Return an expression at constant θ = θ_0, ψ' = ψ_0' and spin Ω_ζ."""
    n = top().names
    theta, psi, phi = n["θ"], n["ψ"], n["φ"]
    second = [(q.diff(t, 2), 0) for q in (theta, psi, phi)]
    first = [(phi.diff(t), n_spin() - psi.diff(t) * cos(theta)), (theta.diff(t), 0), (psi.diff(t), rate_0)]
    pairs = [*second, *first, (theta, theta_0), (psi, 0)]  # the ground's X along ξ
    return x.applyfunc(lambda e: put(e, pairs)) if isinstance(x, sympy.MatrixBase) else put(own(x), pairs)


def n_spin() -> Any:
    """Ω_ζ as a symbol."""
    return POSITIVE["Omega_zeta"]


def condition() -> Any:
    """Return the factor of the library's steady equation other than sin θ_0."""
    ((first, _),) = precession().branches
    return at_steady(first)


def steady_spin() -> list[tuple[Any, Any]]:
    """Return Ω_ζ from the steady condition, which is linear in it."""
    return machines.solved([condition()], [n_spin()])


def rate(name: str) -> Any:
    """Return ψ_0' of the fast or the slow precession by the library."""
    return at_steady(precession()[name].solution["psi'"])


def _kept() -> Meaning:
    """θ and ψ' in the motion from a steady state: their first and second rates."""
    meaning = top()
    n = meaning.names
    theta, psi, phi = n["θ"], n["ψ"], n["φ"]
    state = [
        (phi.diff(t), n_spin() - psi.diff(t) * cos(theta)),
        (theta.diff(t), 0),
        (psi.diff(t), rate_0),
        (theta, theta_0),
    ]
    return Meaning(
        {**n, "θ_0": theta_0, "ψ_0'": rate_0}, along=meaning.along, steady=[*state, *steady_spin()]
    )


def _named() -> dict[str, Any]:
    """Parameters and the names of the steady state."""
    n = top().names
    return {
        **{k: n[k] for k in ("m", "g", "L", "I_ξ", "I_ζ")},
        "Ω_ζ": n_spin(),
        "θ_0": theta_0,
        "ψ_0'": rate_0,
    }


def _quadratic() -> Meaning:
    return Meaning({**_named(), "θ": sympy.Symbol("theta", real=True)}, along=steady_spin())


def _same_angle() -> list[tuple[Any, Any]]:
    return [(sympy.Symbol("theta", real=True), theta_0)]


def _existence() -> Meaning:
    (exists,) = precession()["fast"].existence
    return Meaning(_named(), positive=at_steady(exists.lhs - exists.rhs))


SLOW = sympy.Symbol("epsilon", positive=True)
"""4 m g L I_ξ cos θ_0/(I_ζ Ω_ζ)²: small for a fast spin."""


def numbers() -> list[tuple[Any, Any]]:
    """Return exact numbers of the gyroscope of section 6.9 at 1 rad, an angle without a special sine or cosine."""
    m, R, L = sympy.Rational(6, 5), sympy.Rational(3, 50), sympy.Rational(1, 10)
    values = (m, L, sympy.Rational(981, 100), m * (R**2 / 4 + L**2), m * R**2 / 2)
    names = ("m", "L", "g", "I_xi", "I_zeta")
    return [*((POSITIVE[n], v) for n, v in zip(names, values, strict=True)), (theta_0, sympy.Integer(1))]


def fast_spin() -> Small:
    """Return ε as a function of the spin; its ordinary size belongs to 300 rad/s."""
    n = _named()
    bound = 4 * n["m"] * n["g"] * n["L"] * n["I_ξ"] * cos(theta_0)
    ordinary = put(bound / (n["I_ζ"] * 300) ** 2, numbers())
    return Small(
        SLOW, ordinary, [(rate_0, rate("slow")), (n_spin(), sympy.sqrt(bound / SLOW) / n["I_ζ"]), *numbers()]
    )


def _roots() -> Meaning:
    """Both rates and the angle of the steady state."""
    return Meaning(
        {**_named(), "ψ_01'": rate("fast"), "ψ_02'": rate("slow"), "ψ'": rate("slow")}, small=fast_spin()
    )


def _exact_roots() -> Meaning:
    return Meaning(_roots().names)


def _steady_vectors() -> Meaning:
    """Vectors along ξηζ in slow precession: H_0, its rates in ground axes and in these axes, M_0 and ω."""
    n = top().names
    axes = {name: vector(*axis) for name, axis in zip("ijk", machines.AXES, strict=True)}
    units = [n[c] for c in "ijk"]
    along = lambda v: vector(*(at_steady(v.dot(u)) for u in units))  # noqa: E731
    apparent = vector(*(at_steady(n["H_0"].dot(u).diff(t)) for u in units))
    names = {
        **_named(), **axes, "θ": theta_0, "H_0": along(n["H_0"]), "dH_0/dt": along(n["H_0"].diff(t)),
        "d'H_0/dt": apparent, "M_0": along(n["M_0"]), "ω": along(n["ω"]),
        **{f"ω_{c}": at_steady(n[f"ω_{c}"]) for c in "ξηζ"},
    }  # fmt: skip
    return Meaning(names, along=steady_spin(), small=fast_spin())


ANGULAR = "fb.equations(s).momentum.angular()"
BALANCES = "fb.equations(s).free_body('rotor', about=0, frame=axes).equations"
WEIGHT = "fb.equations(s).free_body('rotor', about=0, frame=axes).moments['weight']"
TURNING = "dynamics.kinematics.angular_velocity"
STEADY = "fb.steady_motions(s, terms={'Omega_zeta': \"phi' + psi'*cos(theta)\"})"


def _top() -> Meaning:
    return top()


def _spin() -> Meaning:
    return Meaning({**top().names, "Ω_ζ": top().names["Ω"].dot(top().names["k"])}, along=top().along)


STATEMENTS = (
    Statement("6.85a", "angular velocity of the axes ξηζ", TURNING + " of the axes; the rates of their unit vectors",
              "ω = ω_ξ i + ω_η j + ω_ζ k", _top, defines=True),
    Statement("6.85b", "angular velocity of the body along these axes: it differs in the last component only",
              TURNING + " of the body and of the axes", "Ω = Ω_ξ i + Ω_η j + Ω_ζ k = ω_ξ i + ω_η j + Ω_ζ k", _top,
              defines=True),
    Statement("6.86", "components of the angular momentum along ξηζ",
              ANGULAR + "; fb.forms.angular_momentum(inertia, omega)",
              "H_0 = H_ξ i + H_η j + H_ζ k", _top, defines=True),
    Statement("6.87", "components of the moment along ξηζ", BALANCES + ", in the ground and in the axes",
              "M_0 = M_ξ i + M_η j + M_ζ k", _moment, defines=True),
    Statement("6.88", "the modified Euler equations", BALANCES + "; " + ANGULAR,
              ("M_ξ = H_ξ' + ω_η H_ζ - ω_ζ H_η", "M_η = H_η' + ω_ζ H_ξ - ω_ξ H_ζ", "M_ζ = H_ζ' + ω_ξ H_η - ω_η H_ξ"),
              _modified),
    Statement("6.89", "components of the angular momentum of a body of revolution", ANGULAR,
              ("H_ξ = I_ξ Ω_ξ = I_ξ ω_ξ", "H_η = I_η Ω_η = I_ξ ω_η", "H_ζ = I_ζ Ω_ζ"), _momentum),
    Statement("6.90", "the modified Euler equations of a body of revolution", "fb.forms.modified_euler_equations()",
              ("M_ξ = I_ξ ω_ξ' + ω_η (I_ζ Ω_ζ - I_ξ ω_ζ)", "M_η = I_ξ ω_η' + ω_ζ (I_ξ ω_ζ - I_ζ Ω_ζ)",
              "M_ζ = I_ζ Ω_ζ'"),
              _explicit),
    Statement("6.91", "angular velocity of the axes ξηζ in Euler's angles", "the rates of the axes' unit vectors",
              ("ω_ξ = θ'", "ω_η = ψ' sin θ", "ω_ζ = ψ' cos θ"), _top),
    Statement("6.92", "angular velocity of the body in Euler's angles", TURNING,
              ("Ω_ξ = ω_ξ = θ'", "Ω_η = ω_η = ψ' sin θ", "Ω_ζ = φ' + ω_ζ = φ' + ψ' cos θ"), _top),
    Statement("6.93", "moment of the weight about the pivot", WEIGHT, ("M_ξ = m g L sin θ", "M_η = 0", "M_ζ = 0"),
              _top),
    Statement("6.94", "the equations of motion of the gyroscope", BALANCES + "; " + WEIGHT,
              ("I_ξ θ'' + ψ' sin θ [I_ξ (φ' + ψ' cos θ) - I_ζ ψ' cos θ] = m g L sin θ",
               "I_ξ d/dt (ψ' sin θ) + θ' [I_ξ ψ' cos θ - I_ζ (φ' + ψ' cos θ)] = 0", "I_ξ d/dt (φ' + ψ' cos θ) = 0"),
              _balances),
    Statement("6.95", "the spin is constant", TURNING + ", along fb.equations(s).motion",
              "φ' + ψ' cos θ = Ω_ζ = const", _spin),
    Statement("6.96", "the equations of nutation and precession", BALANCES + "; " + WEIGHT,
              ("I_ξ θ'' + ψ' sin θ (I_ζ Ω_ζ - I_ξ ψ' cos θ) = m g L sin θ",
               "I_ξ d/dt (ψ' sin θ) + θ' (I_ξ ψ' cos θ - I_ζ Ω_ζ) = 0"), _balances),
    Statement("6.97", "steady precession: what is constant in it stays so", STEADY + ", along fb.equations(s).motion",
              ("θ = θ_0 = const", "ψ' = ψ_0' = const"), _kept, defines=True),
    Statement("6.98", "the condition of steady precession", STEADY + ".branches",
              "ψ_0'^2 - I_ζ Ω_ζ/(I_ξ cos θ_0) ψ_0' + m g L/(I_ξ cos θ) = 0", _quadratic,
              condition=("theta, without index in the last term, stands for theta_0", _same_angle)),
    Statement("6.99", "the two rates of steady precession", STEADY + "['fast'].solution",
              tuple(f"ψ_0{i}' = I_ζ Ω_ζ/(2 I_ξ cos θ_0) {sign} I_ζ Ω_ζ/(2 I_ξ cos θ_0)"
                    " (1 - 4 m g L I_ξ cos θ_0/(I_ζ^2 Ω_ζ^2))^(1/2)" for i, sign in ((1, "+"), (2, "-"))),
                    _exact_roots),
    Statement("6.100", "the spin for which steady precession exists", STEADY + "['fast'].existence",
              "Ω_ζ^2 > 4 m g L I_ξ cos θ_0/I_ζ^2", _existence),
    Statement("6.101", "the root for a fast spin; epsilon = 4 m g L I_xi cos(theta_0)/(I_zeta Omega_zeta)^2",
              "the root itself",
              "(1 - 4 m g L I_ξ cos θ_0/(I_ζ^2 Ω_ζ^2))^(1/2) ≅ 1 - 2 m g L I_ξ cos θ_0/(I_ζ^2 Ω_ζ^2)",
              _roots),
    Statement("6.102", "fast and slow precession for a fast spin", STEADY + "['fast'].solution",
              ("ψ_01' ≅ I_ζ Ω_ζ/(I_ξ cos θ_0)", "ψ_02' ≅ m g L/(I_ζ Ω_ζ)"), _roots),
    Statement("6.103", "the angular momentum in slow precession, along the axis; i, j, k along ξηζ",
              ANGULAR + "; " + STEADY, ("H_0 = I_ζ Ω_ζ k", "dH_0/dt = 0"), _steady_vectors),
    Statement("6.104", "the moment as a vector", WEIGHT, "M_0 = m g L sin θ i", _top),
    Statement("6.105", "the moment turns the angular momentum; i, j, k along ξηζ",
              WEIGHT + "; " + ANGULAR + "; " + STEADY,
              "M_0 = ω × H_0 = (ω_ξ i + ω_η j + ω_ζ k) × I_ζ Ω_ζ k = -ω_ξ I_ζ Ω_ζ j + ω_η I_ζ Ω_ζ i = m g L sin θ i",
              _steady_vectors),
    Statement("6.106", "the rate of slow precession", STEADY + "['slow'].solution", "ψ' = m g L/(I_ζ Ω_ζ)", _roots),
)  # fmt: skip
