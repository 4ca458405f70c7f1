"""Names as they are typeset: Greek letters, subscripts, words upright."""

from __future__ import annotations

import re
from functools import cache

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η",
    "theta": "θ", "iota": "ι", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "upsilon": "υ", "phi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω",
    "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Pi": "Π", "Sigma": "Σ",
    "Upsilon": "Υ", "Phi": "Φ", "Psi": "Ψ", "Omega": "Ω",
}  # fmt: skip
SPELLED = {"lam": "lambda", "lamda": "lambda"}
"""Letters by what they are called in Python, where the word itself is reserved."""
SPEED = re.compile(r"(\w*[A-Za-z0-9])_([wv])([xyz])")
"""Names of the speeds of ball and free joints, and of what is called like them: component of the joint's ω or v."""
LETTERS = {"w": "omega", "v": "v"}


@cache
def parts(name: str) -> tuple[str, str]:
    """Return (base, subscript): ``theta_1`` and ``theta1`` are θ with subscript 1. Speeds of a ball or free joint j,
    ``j_wx`` and ``j_vx``, are ω and v with x and j.

    >>> parts("theta1"), parts("I_xx"), parts("arm_2_x"), parts("T1_floor"), parts("mass"), parts("j_wx")
    (('theta', '1'), ('I', 'xx'), ('arm', '2, x'), ('T', '1, floor'), ('mass', ''), ('omega', 'x, j'))
    """
    if speed := SPEED.fullmatch(name):
        return LETTERS[speed[2]], f"{speed[3]}, {speed[1].strip('_').replace('_', ', ')}"
    base, _, ending = name.strip("_").partition("_")
    match = re.fullmatch(r"([A-Za-z]+?)(\d+)", base)
    subscripts = [match.group(2)] if match else []
    if ending:
        subscripts.append(ending.strip("_").replace("_", ", "))
    letter = match.group(1) if match else base
    return SPELLED.get(letter, letter), ", ".join(subscripts)
