"""Reference motions to 30 digits; ``python -m benchmarks.references`` computes ``references.json`` anew.

Integrated with a Taylor method written here on mpmath numbers (45 digits, order 50): no code of freebody and no
peer takes part. Each motion is then checked against its closed form in Jacobi's elliptic functions, by mpmath.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

PATH = Path(__file__).with_name("references.json")
DIGITS, ORDER = 45, 50

# Section 6.9 of the chapter, with a spin slow enough that the nutation is large: the shaft is let go from rest.
TOP = {"m": "1.2", "R": "0.06", "L": "0.1", "g": "9.81", "spin": "100", "cos_theta0": "0.5"}
# Middle axis, nearly: turns over every few seconds.
BODY = {"moments": ["1", "2", "3"], "w0": ["0.01", "3", "0.02"]}

Term = tuple[Any, int, int]  # coefficient, index, index (-1: the factor 1)


def taylor(equations: list[list[Term]], start: list[Any], times: list[Any]) -> list[list[Any]]:
    """Solution of y_i' = sum of c y_a y_b at ``times``, by Taylor series of order ORDER."""
    from mpmath import mp

    y, now, out = list(start), mp.mpf(0), []
    tolerance = mp.mpf(10) ** (5 - DIGITS)
    for target in times:
        while now < target:
            series = [[value] for value in y]
            for k in range(ORDER):
                reverse = [column[::-1] for column in series]
                new = []
                for terms in equations:
                    total = mp.mpf(0)
                    for c, a, b in terms:
                        total += c * (series[a][k] if b < 0 else mp.fdot(series[a], reverse[b]))
                    new.append(total / (k + 1))
                for column, value in zip(series, new, strict=True):
                    column.append(value)
            last = max(abs(column[-1]) for column in series)
            step = min(
                target - now, mp.mpf(2) ** int(mp.log((tolerance / last) ** (mp.mpf(1) / ORDER), 2) - 1)
            )
            y = [mp.polyval(column[::-1], step) for column in series]
            now += step
        out.append(list(y))
    return out


def quaternion_terms(first: int, rates: list[list[Term]], side: str) -> list[list[Term]]:
    """Rows of q' = q w / 2 ("body": w in body axes) or w q / 2 ("ground"), q at ``first`` .. ``first + 3``.

    ``rates[j]`` is w_j as terms (c, index, -1).
    """
    s = 1 if side == "body" else -1
    # q' = (-q.w, q_0 w +- q x w) / 2 with q x w for body components, w x q for ground ones
    table = [
        [(-1, 1, 0), (-1, 2, 1), (-1, 3, 2)],
        [(1, 0, 0), (s, 2, 2), (-s, 3, 1)],
        [(1, 0, 1), (s, 3, 0), (-s, 1, 2)],
        [(1, 0, 2), (s, 1, 1), (-s, 2, 0)],
    ]
    return [
        [(sign * c / 2, first + q, index) for sign, q, w in row for c, index, _ in rates[w]] for row in table
    ]


def heavy_top(times: list[Any]) -> list[list[Any]]:
    """Attitude quaternions (w, x, y, z) of R_NB, body axes from ZXZ angles psi, theta, phi; psi = phi = 0 at 0.

    Axis e and moment of momentum H in ground axes: e' = (H / I_xi) x e, H' = -m g L e x Z; a frame that turns
    with H / I_xi carries e, and the body turns in it at Omega (1 - I_zeta / I_xi).
    """
    from mpmath import mp

    m, R, L, g, spin, u0 = (mp.mpf(TOP[name]) for name in ("m", "R", "L", "g", "spin", "cos_theta0"))
    I_xi, I_zeta, W = m * R**2 / 4 + m * L**2, m * R**2 / 2, m * g * L
    s0 = mp.sqrt(1 - u0**2)
    i = 1 / I_xi
    e, H = (0, 1, 2), (3, 4, 5)
    equations: list[list[Term]] = []
    for a, b in ((1, 2), (2, 0), (0, 1)):
        equations.append([(i, H[a], e[b]), (-i, H[b], e[a])])
    # H' = L e x (0, 0, -m g) = -W (e_y, -e_x, 0)
    equations += [[(-W, 1, -1)], [(W, 0, -1)], []]
    equations += quaternion_terms(6, [[(i, H[k], -1)] for k in range(3)], "ground")
    axis = [mp.mpf(0), -s0, u0]
    half = mp.acos(u0) / 2
    start = [
        *axis,
        *(I_zeta * spin * component for component in axis),
        mp.cos(half),
        mp.sin(half),
        mp.mpf(0),
        mp.mpf(0),
    ]
    out = []
    for t, y in zip(times, taylor(equations, start, times), strict=True):
        w, x, yq, z = y[6:]
        angle = spin * (1 - I_zeta / I_xi) * t / 2
        c, s = mp.cos(angle), mp.sin(angle)
        out.append([w * c - z * s, x * c + yq * s, yq * c - x * s, z * c + w * s])
    return out


def heavy_top_closed(t: Any) -> list[Any]:
    """The same attitude from elliptic functions and integrals of the third kind."""
    from mpmath import mp

    m, R, L, g, spin, u0 = (mp.mpf(TOP[name]) for name in ("m", "R", "L", "g", "spin", "cos_theta0"))
    I_xi, I_zeta, W = m * R**2 / 4 + m * L**2, m * R**2 / 2, m * g * L
    a, b = I_zeta * spin / I_xi, 2 * W / I_xi
    s = a**2 / (2 * b)
    root = mp.sqrt(s**2 - 2 * s * u0 + 1)
    u1, u2 = s - root, s + root
    n, p = (u0 - u1) / (u2 - u1), mp.sqrt(b * (u2 - u1)) / 2
    K = mp.ellipk(n)
    tau = p * t + K
    turns = mp.nint(tau / (2 * K))
    rest = tau - 2 * K * turns
    sn, cn = mp.ellipfun("sn", rest, m=n), mp.ellipfun("cn", rest, m=n)
    amplitude = mp.atan2(sn, cn)
    theta = mp.acos(u0 - (u0 - u1) * cn**2)

    def third(c: Any) -> Any:
        return ((2 * turns - 1) * mp.ellippi(c, n) + mp.ellippi(c, amplitude, n)) / p

    J1 = third((u0 - u1) / (1 - u1)) / (1 - u1)
    J2 = third(-(u0 - u1) / (1 + u1)) / (1 + u1)
    psi = a / 2 * ((1 + u0) * J2 - (1 - u0) * J1)
    phi = spin * t - a * (t - (1 - u0) / 2 * J1 - (1 + u0) / 2 * J2)
    c, s = mp.cos(theta / 2), mp.sin(theta / 2)
    plus, minus = (psi + phi) / 2, (psi - phi) / 2
    return [c * mp.cos(plus), s * mp.cos(minus), s * mp.sin(minus), c * mp.sin(plus)]


def tumbling(times: list[Any]) -> tuple[list[list[Any]], list[list[Any]]]:
    """Attitude quaternions of R_NB (1 at t = 0) and angular velocities in body axes."""
    from mpmath import mp

    I1, I2, I3 = (mp.mpf(value) for value in BODY["moments"])
    equations: list[list[Term]] = [
        [((I2 - I3) / I1, 1, 2)],
        [((I3 - I1) / I2, 2, 0)],
        [((I1 - I2) / I3, 0, 1)],
    ]
    equations += quaternion_terms(3, [[(mp.mpf(1), k, -1)] for k in range(3)], "body")
    start = [*(mp.mpf(value) for value in BODY["w0"]), mp.mpf(1), mp.mpf(0), mp.mpf(0), mp.mpf(0)]
    states = taylor(equations, start, times)
    return [y[3:] for y in states], [y[:3] for y in states]


def tumbling_closed(t: Any) -> list[Any]:
    """Angular velocity from Jacobi's functions, for I_1 < I_2 < I_3 and H² > 2 T I_2, w > 0 at the start."""
    from mpmath import mp

    I1, I2, I3 = (mp.mpf(value) for value in BODY["moments"])
    w1, w2, w3 = (mp.mpf(value) for value in BODY["w0"])
    H2, T2 = I1**2 * w1**2 + I2**2 * w2**2 + I3**2 * w3**2, I1 * w1**2 + I2 * w2**2 + I3 * w3**2
    A, B = T2 * I3 - H2, H2 - T2 * I1
    assert H2 > T2 * I2 and w3 > 0
    a, b, c = mp.sqrt(A / (I1 * (I3 - I1))), mp.sqrt(A / (I2 * (I3 - I2))), mp.sqrt(B / (I3 * (I3 - I1)))
    p, k2 = mp.sqrt((I3 - I2) * B / (I1 * I2 * I3)), (I2 - I1) * A / ((I3 - I2) * B)
    tau = p * t + mp.ellipf(mp.atan2(w2 / b, w1 / a), k2)
    return [
        a * mp.ellipfun("cn", tau, m=k2),
        b * mp.ellipfun("sn", tau, m=k2),
        c * mp.ellipfun("dn", tau, m=k2),
    ]


def references() -> dict[str, Any]:
    """The stored reference motions, as floats: times, quaternions (w, x, y, z) and the parameters."""
    import numpy as np

    data = json.loads(PATH.read_text(encoding="utf-8"))
    for motion in data.values():
        for name in ("times", "quaternions"):
            motion[name] = np.array(motion[name], dtype=float)
    return data


def main() -> None:
    """Compute, check against the closed forms, write."""
    from mpmath import mp

    mp.dps = DIGITS

    def text(rows: list[list[Any]]) -> list[list[str]]:
        return [[mp.nstr(value, 32) for value in row] for row in rows]

    times = [mp.mpf(k) for k in range(1, 11)]
    top = heavy_top(times)
    worst = mp.mpf(0)
    for t, q in zip(times, top, strict=True):
        closed = heavy_top_closed(t)
        sign = mp.sign(mp.fdot(q, closed))
        worst = max(worst, *(abs(x - sign * y) for x, y in zip(q, closed, strict=True)))
    print("heavy top: largest difference from the closed form", mp.nstr(worst, 3))
    assert worst < mp.mpf(10) ** -32
    tens = [mp.mpf(10 * k) for k in range(1, 11)]
    quaternions, omegas = tumbling(tens)
    worst = max(
        abs(x - y)
        for t, w in zip(tens, omegas, strict=True)
        for x, y in zip(w, tumbling_closed(t), strict=True)
    )
    print("tumbling body: largest difference from the closed form", mp.nstr(worst, 3))
    assert worst < mp.mpf(10) ** -30
    data = {
        "heavy_top": {
            "parameters": TOP,
            "times": [mp.nstr(t, 5) for t in times],
            "quaternions": text(top),
        },
        "tumbling": {
            "parameters": BODY,
            "times": [mp.nstr(t, 5) for t in tens],
            "quaternions": text(quaternions),
            "omegas": text(omegas),
        },
    }
    PATH.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
