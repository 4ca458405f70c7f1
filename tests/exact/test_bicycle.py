"""Whipple's bicycle against the published benchmark: coefficients, eigenvalues, stable speeds.

Meijaard, Papadopoulos, Ruina & Schwab, Proc. R. Soc. A 463 (2007) 1955-1982: eqs (A 3) and (A 4), table 2. Printed
with 14 to 15 digits; DIGITS of them are asked for.
"""

import subprocess
import sys

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.conditions.constrained import independent_rows
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.motion import motion
from freebody.dynamics.state import float_state
from freebody.gallery.beyond import whipple_bicycle as bicycle

DIGITS = 1e-12

M = [[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]]
C1 = [[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]]
K0 = [[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]]
K2 = [[0, 76.59734589573222], [0, 2.65431523794604]]

# v: real and imaginary part of weave, capsize, castering
EIGENVALUES = {
    1: (3.52696170990070, 0.80774027519930, -3.13423125066578, -7.11008014637442),
    2: (2.68234517512745, 1.68066296590675, -3.07158645641514, -8.67387984831735),
    3: (1.70675605663975, 2.31582447384325, -2.63366137253667, -10.35101467245920),
    4: (0.41325331521125, 3.07910818603206, -1.42944427361326, -12.15861426576447),
    5: (-0.77534188219585, 4.46486771378823, -0.32286642900409, -14.07838969279822),
    6: (-1.52644486584142, 5.87673060598709, -0.00406690076970, -16.08537123098026),
    7: (-2.13875644258362, 7.19525913329805, 0.10268170574766, -18.15788466125262),
    8: (-2.69348683581097, 8.46037971396931, 0.14327879765713, -20.27940894394569),
    9: (-3.21675402252485, 9.69377351531791, 0.15790184030917, -22.43788559040858),
    10: (-3.72016840437287, 10.90681139476287, 0.16105338653172, -24.62459635017404),
}
AT_REST = (5.53094371765393, 3.13164324790656)

MODEL = fb.assemble(bicycle.build())
VALUES = MODEL.values({})


@pytest.fixture(scope="module")
def parts():
    return bicycle.coefficients(MODEL, VALUES)


@pytest.mark.parametrize(("name", "printed"), [("M", M), ("C1", C1), ("K0", K0), ("K2", K2)])
def test_coefficients(parts, name, printed):
    scale = np.abs(printed).max()
    assert parts[name] == pytest.approx(np.array(printed), rel=DIGITS, abs=DIGITS * scale)


def linear_at(v):
    """Eigenvalues of the linear equations formed at this speed, not combined from others."""
    mass, C, K = bicycle.linear(MODEL, v, VALUES)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, K), -np.linalg.solve(mass, C)]])
    return np.linalg.eigvals(A)


@pytest.mark.parametrize("v", EIGENVALUES)
def test_eigenvalues(parts, v):
    real, imaginary, capsize, castering = EIGENVALUES[v]
    for found in (linear_at(v), bicycle.eigenvalues(parts, v, VALUES["g"])):
        pair = [z for z in found if z.imag > 0]
        assert len(pair) == 1
        assert pair[0] == pytest.approx(complex(real, imaginary), rel=DIGITS)
        # a root is as exact as the terms that cancel in it
        assert sorted(z.real for z in found if z.imag == 0) == pytest.approx(
            [castering, capsize], rel=DIGITS, abs=DIGITS * abs(castering)
        )


def test_eigenvalues_at_rest():
    found = sorted(linear_at(0).real)
    assert found == pytest.approx([-AT_REST[0], -AT_REST[1], AT_REST[1], AT_REST[0]], rel=DIGITS)


def test_stable_speeds(parts):
    assert bicycle.stable_speeds(parts, VALUES["g"]) == pytest.approx(
        (4.29238253634111, 6.02426201538837), rel=DIGITS
    )


def test_backwards_it_is_unstable(parts):
    """The reversed motion has the eigenvalues with opposite sign: the equations are reversible."""
    forward = bicycle.eigenvalues(parts, 5, VALUES["g"])
    backward = bicycle.eigenvalues(parts, -5, VALUES["g"])
    assert np.sort_complex(-forward) == pytest.approx(np.sort_complex(backward), rel=1e-9)


def test_upright_equilibrium_of_forces():
    """Wheel loads of the straight running bicycle: the moments of the weights about the contacts."""
    u = dict.fromkeys(MODEL.speed_names, 0.0) | {"air_vx": 5.0, "theta_R'": -5 / 0.3, "theta_F'": -5 / 0.35}
    state = float_state(MODEL, None, [u[name] for name in MODEL.speed_names])
    assert np.abs(np.array(linearized(MODEL, state).rate, dtype=float)).max() < 1e-14
    moving = motion(MODEL, state, independent_rows(MODEL, state))
    front = 9.81 * (85 * 0.3 + 4 * 0.9 + 3 * 1.02) / 1.02
    assert moving.multipliers[3] == pytest.approx(front, rel=1e-13)
    assert moving.multipliers[0] == pytest.approx(9.81 * 94 - front, rel=1e-13)
    assert moving.udot == pytest.approx([0] * MODEL.n_u, abs=1e-11)


def test_nonlinear_motion_follows_the_linear_one(parts):
    """A small kick: the steer of the simulation is that of the linear equations, to the square of the kick."""
    kick, t = 1e-4, 1.5
    found = fb.simulate(MODEL, t, initial=bicycle.KICK, values={"kick": kick}, tolerance=1e-12)
    A = np.vstack([
        np.hstack([np.zeros((2, 2)), np.eye(2)]),
        np.linalg.solve(parts["M"], np.hstack([-9.81 * parts["K0"] - 25 * parts["K2"], -5 * parts["C1"]])),
    ])  # fmt: skip
    from scipy.linalg import expm

    # the rate of steer that the least change of motion gives is part of the start
    start = [0, 0, found["air_wx"][0], found["delta'"][0]]
    linear = expm(A * t) @ start
    assert found["delta"][-1] == pytest.approx(linear[1], abs=100 * kick**2)
    assert found["air_wx"][-1] == pytest.approx(linear[2], abs=100 * kick**2)


def test_energy_is_kept_in_a_large_motion():
    found = fb.simulate(MODEL, 3, initial=bicycle.KICK, tolerance=1e-10)
    assert found.energy.relative_residual < 1e-10
    assert abs(found["delta"]).max() > 0.1


def test_from_the_command_of_a_new_process():
    """Import, model, linear equations and eigenvalues, in a fresh process; `benchmarks.bicycle` measures it."""
    script = (
        "import numpy as np\n"
        "from freebody.gallery.beyond import whipple_bicycle as b\n"
        "import freebody as fb\n"
        "m = fb.assemble(b.build()); values = m.values({})\n"
        "for v in (0, 5):\n"
        "    M, C, K = b.linear(m, v, values)\n"
        "print(b.eigenvalues(b.coefficients(m, values), 5, 9.81)[0])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("(-0.77534188219")
