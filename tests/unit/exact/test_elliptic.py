"""Complete elliptic integrals to a hundred digits, and the arithmetic that they use."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import pytest

from freebody.exact.elliptic import DIGITS, complete_pulse, complete_third, precise


@pytest.mark.parametrize(("m1", "nu"), [("0.3", "2.5"), ("1e-6", "0.25"), ("0.75", "-0.4"), ("0.5", "1e-40")])
def test_complete_integrals_are_those_of_their_definitions(m1: str, nu: str) -> None:
    mp = precise()
    k1, n = mp.mpf(m1), mp.mpf(nu)

    def integral(numerator: object) -> object:
        # over the amplitude: d tau = d phi / sqrt(cos² + k'² sin²)
        def f(phi: object) -> object:
            s, c = mp.sin(phi), mp.cos(phi)
            return numerator(c) / ((1 + n * s**2) * mp.sqrt(c**2 + k1 * s**2))  # type: ignore[operator]

        return mp.quad(f, mp.linspace(0, mp.pi / 2, 12))

    assert abs(complete_third(k1, n) - integral(lambda c: 1)) < mp.mpf(10) ** -20
    assert abs(complete_pulse(k1, n) - integral(lambda c: c**2)) < mp.mpf(10) ** -20


def test_a_fraction_keeps_its_digits_and_each_thread_has_its_own_precision() -> None:
    third = precise().convert(Fraction(1, 3))
    assert abs(3 * third - 1) < precise().mpf(10) ** (1 - DIGITS)
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(precise).result() is not precise()
    assert precise() is precise()


def test_the_import_does_not_load_mpmath() -> None:
    code = "import sys, freebody.exact; sys.exit('mpmath' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
