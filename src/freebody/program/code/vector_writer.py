"""Writer of elementary functions as LLVM IR, for one double or a vector of doubles."""

from __future__ import annotations

from collections.abc import Sequence

from ...native.ir_text import literal, splat


class VectorWriter:
    """Lines of one function of doubles or vectors; every method writes one operation and returns its name."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        self.T, self.suffix = ("double", "f64") if lanes == 1 else (f"<{lanes} x double>", f"v{lanes}f64")
        self.J = "i64" if lanes == 1 else f"<{lanes} x i64>"
        self.B = "i1" if lanes == 1 else f"<{lanes} x i1>"
        self.lines: list[str] = []

    def emit(self, operation: str) -> str:
        """Write an operation."""
        target = f"%v{len(self.lines)}"
        self.lines.append(f"  {target} = {operation}")
        return target

    def number(self, value: float) -> str:
        """A real constant in every lane."""
        return splat(literal(value), self.lanes)

    def integer(self, value: int) -> str:
        """An integer constant in every lane."""
        return splat(str(value), self.lanes, "i64")

    def add(self, a: str, b: str) -> str:
        """a + b."""
        return self.emit(f"fadd {self.T} {a}, {b}")

    def sub(self, a: str, b: str) -> str:
        """a - b."""
        return self.emit(f"fsub {self.T} {a}, {b}")

    def mul(self, a: str, b: str) -> str:
        """a b."""
        return self.emit(f"fmul {self.T} {a}, {b}")

    def div(self, a: str, b: str) -> str:
        """a / b."""
        return self.emit(f"fdiv {self.T} {a}, {b}")

    def neg(self, a: str) -> str:
        """-a."""
        return self.emit(f"fneg {self.T} {a}")

    def fma(self, a: str, b: str, c: str) -> str:
        """a b + c with one rounding."""
        return self.emit(f"call {self.T} @llvm.fma.{self.suffix}({self.T} {a}, {self.T} {b}, {self.T} {c})")

    def size(self, a: str) -> str:
        """|a|."""
        return self.emit(f"call {self.T} @llvm.fabs.{self.suffix}({self.T} {a})")

    def sqrt(self, a: str) -> str:
        """√a."""
        return self.emit(f"call {self.T} @llvm.sqrt.{self.suffix}({self.T} {a})")

    def signed(self, a: str, sign: str) -> str:
        """|a| with the sign of another number."""
        return self.emit(f"call {self.T} @llvm.copysign.{self.suffix}({self.T} {a}, {self.T} {sign})")

    def compare(self, how: str, a: str, b: str) -> str:
        """Mask of a comparison of real numbers."""
        return self.emit(f"fcmp {how} {self.T} {a}, {b}")

    def either(self, a: str, b: str) -> str:
        """a or b, of masks."""
        return self.emit(f"or {self.B} {a}, {b}")

    def choose(self, condition: str, a: str, b: str) -> str:
        """a where the condition holds, else b."""
        return self.emit(f"select {self.B} {condition}, {self.T} {a}, {self.T} {b}")

    def bits(self, a: str) -> str:
        """The bits of real numbers as integers."""
        return self.emit(f"bitcast {self.T} {a} to {self.J}")

    def double(self, a: str) -> str:
        """Real numbers with the bits of integers."""
        return self.emit(f"bitcast {self.J} {a} to {self.T}")

    def whole(self, operation: str, a: str, b: str) -> str:
        """An operation on integers."""
        return self.emit(f"{operation} {self.J} {a}, {b}")

    def polynomial(self, coefficients: Sequence[float], z: str, zz: str) -> str:
        """Σ coefficients z^i in two chains, of even and of odd powers (Estrin's first step): shorter to wait for."""
        sums = []
        for part in (coefficients[0::2], coefficients[1::2]):
            value = self.number(part[-1])
            for c in reversed(part[:-1]):
                value = self.fma(value, zz, self.number(c))
            sums.append(value)
        return self.fma(sums[1], z, sums[0])

    # double-double arithmetic: a pair is the sum of its members, the second far below the first

    def two_sum(self, a: str, b: str) -> tuple[str, str]:
        """a + b for |a| ≥ |b|, with its rounding error (Dekker)."""
        s = self.add(a, b)
        return s, self.sub(b, self.sub(s, a))

    def two_product(self, a: str, b: str) -> tuple[str, str]:
        """a b with its rounding error."""
        p = self.mul(a, b)
        return p, self.fma(a, b, self.neg(p))

    def product(self, a: tuple[str, str], b: tuple[str, str]) -> tuple[str, str]:
        """Product of two pairs."""
        h, low = self.two_product(a[0], b[0])
        low = self.fma(a[0], b[1], low)
        low = self.fma(a[1], b[0], low)
        return self.two_sum(h, low)
