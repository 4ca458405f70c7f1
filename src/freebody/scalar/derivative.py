"""Derivatives of recorded programs, recorded on the same tape.

    forward    ẏ = (∂y/∂x) ẋ          one sweep per direction ẋ
    reverse    x̄ = (∂y/∂x)ᵀ ȳ         one sweep per output y

Both add at most a few operations per operation passed. Constants stay plain numbers, so that a direction or an
output without influence costs nothing.

Source: A. Griewank, A. Walther, Evaluating Derivatives (2008), chapters 2 and 3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from ..errors import ExpressionError
from .algebra import Scalar
from .trace import ADD, CODES, DIV, INPUT, MUL, NEG, SUB, Tape, Traced


def forward(
    tape: Tape, outputs: Sequence[Scalar], wrt: Sequence[Traced], seeds: Sequence[Scalar]
) -> list[Scalar]:
    """Derivatives of the outputs along a direction.

    Parameters
    ----------
    tape : Tape
    outputs : sequence of scalars, length m
    wrt : sequence of Traced, length n
        Variables; a variable that is computed from other nodes is treated as independent of them.
    seeds : sequence of scalars, length n
        The direction: rates of the variables.

    Returns
    -------
    list of scalars, length m
        Σ_j (∂output_i/∂x_j) seed_j.
    """
    _check(tape, wrt)
    if len(seeds) != len(wrt):
        raise ExpressionError(f"Expected one seed for each of the {len(wrt)} variables, got {len(seeds)}.")
    tangent: dict[int, Scalar] = {x.index: seed for x, seed in zip(wrt, seeds, strict=True)}
    for i in _used(tape, outputs):
        if i in tangent or tape.op[i] <= INPUT:
            continue
        p, q = tape.a[i], tape.b[i]
        dp, dq = tangent.get(p, 0), tangent.get(q, 0) if q >= 0 else 0
        if _is_zero(dp) and _is_zero(dq):
            continue
        tangent[i] = sum(
            (rate * partial for rate, partial in zip((dp, dq), _partials(tape, i, dp, dq), strict=False)), 0
        )
    return [tangent.get(y.index, 0) if type(y) is Traced else 0 for y in outputs]


def beside(
    tape: Tape, functions: Mapping[str, Sequence[Scalar]], wrt: Sequence[Traced]
) -> tuple[dict[str, list[Scalar]], list[Traced]]:
    """Outputs of functions, each followed by its derivative, and variables, each followed by its rate."""
    rates = [tape.input(f"rate of {tape.inputs[tape.a[x.index]]}") for x in wrt]
    results = {
        name: [x for pair in zip(outputs, forward(tape, outputs, wrt, rates), strict=True) for x in pair]
        for name, outputs in functions.items()
    }
    return results, [x for pair in zip(wrt, rates, strict=True) for x in pair]


def reverse(tape: Tape, output: Scalar, wrt: Sequence[Traced]) -> list[Scalar]:
    """Gradient of one output: ∂output/∂x_j for each variable of ``wrt``."""
    return transposed(tape, [output], [1], wrt)


def transposed(
    tape: Tape, outputs: Sequence[Scalar], weights: Sequence[Scalar], wrt: Sequence[Traced]
) -> list[Scalar]:
    """Gradient of Σ_i weight_i output_i with respect to ``wrt``, with constant weights."""
    _check(tape, wrt)
    if len(weights) != len(outputs):
        raise ExpressionError(
            f"Expected one weight for each of the {len(outputs)} outputs, got {len(weights)}."
        )
    stop = {x.index for x in wrt}
    active = _depending(tape, outputs, stop)
    adjoint: dict[int, Scalar] = {}
    for y, weight in zip(outputs, weights, strict=True):
        if type(y) is Traced:
            adjoint[y.index] = adjoint.get(y.index, 0) + weight
    for i in reversed(active):
        if i in stop or i not in adjoint:
            continue
        y_bar = adjoint[i]
        operands = (tape.a[i], tape.b[i])
        marks = [1 if p >= 0 and p in active else 0 for p in operands]
        for p, mark, partial in zip(operands, marks, _partials(tape, i, *marks), strict=False):
            if mark:
                adjoint[p] = adjoint.get(p, 0) + y_bar * partial
    return [adjoint.get(x.index, 0) for x in wrt]


def jacobian(tape: Tape, outputs: Sequence[Scalar], wrt: Sequence[Traced]) -> list[list[Scalar]]:
    """Rows of ∂output_i/∂x_j, by forward or reverse sweeps, whichever are fewer."""
    if len(outputs) < len(wrt):
        return [reverse(tape, y, wrt) for y in outputs]
    columns = [forward(tape, outputs, [x], [1]) for x in wrt]
    return [[column[i] for column in columns] for i in range(len(outputs))]


def _check(tape: Tape, wrt: Sequence[Any]) -> None:
    for x in wrt:
        if type(x) is not Traced or x.tape is not tape:
            raise ExpressionError(f"Expected variables that are scalars of the tape, got {x!r}.")


def _used(tape: Tape, outputs: Sequence[Scalar]) -> list[int]:
    for y in outputs:
        if type(y) is Traced and y.tape is not tape:
            raise ExpressionError(f"Expected outputs of the tape, got {y!r} of another.")
    return tape.used(outputs)


def _depending(tape: Tape, outputs: Sequence[Scalar], variables: set[int]) -> dict[int, None]:
    """The nodes between the variables and the outputs, operands first."""
    active: dict[int, None] = {}
    op, a, b = tape.op, tape.a, tape.b
    for i in _used(tape, outputs):
        if i in variables or (op[i] > INPUT and (a[i] in active or b[i] in active)):
            active[i] = None
    return active


def _is_zero(x: Scalar) -> bool:
    return type(x) is not Traced and x == 0


def _partials(tape: Tape, i: int, first: Scalar, second: Scalar) -> tuple[Scalar, ...]:
    """Partial derivatives of node i by its operands; 0 for an operand whose use, ``first`` or ``second``, is zero."""
    code = tape.op[i]
    x = tape.scalar(tape.a[i])
    v = tape.scalar(i)
    if code == NEG:
        return (-1,)
    if tape.b[i] < 0:
        return (_UNARY[code](tape, x, v),)
    y = tape.scalar(tape.b[i])
    use, use_second = not _is_zero(first), not _is_zero(second)
    if code == ADD:
        return (1, 1)
    if code == SUB:
        return (1, -1)
    if code == MUL:
        return (y, x)
    if code == DIV:
        return (1 / y if use else 0, -(v / y) if use_second else 0)
    if code == CODES["pow"]:
        return (
            y * tape.apply("pow", x, y - 1) if use else 0,
            v * tape.apply("log", x) if use_second else 0,
        )
    if code == CODES["atan2"]:  # angle of the point (y, x)
        square = x * x + y * y
        return (y / square, -(x / square))
    # min and max: the mean of both derivatives where the operands are equal
    side = tape.apply("sign", x - y) / 2
    half = Fraction(1, 2)
    return (half - side, half + side) if code == CODES["min"] else (half + side, half - side)


def _slope_of_root(tape: Tape, x: Scalar, v: Scalar) -> Scalar:
    """Return the derivative of √x.

    A length √(a² + b² + …) has no derivative where it is zero, and any of its products with what is zero there, such
    as the drag |v| v, has the derivative that follows with 0 for that of the length. 1/(2·0) would make 0/0 of it.
    """
    if not (type(x) is Traced and _is_sum_of_squares(tape, x.index)):
        return 1 / (2 * v)
    positive = tape.apply("sign", v)  # 1, or 0 where the length is zero
    return positive / (2 * v + (1 - positive))


def _is_sum_of_squares(tape: Tape, i: int) -> bool:
    """Return whether a node is a sum of squares of nodes."""
    nodes = [i]
    while nodes:
        i = nodes.pop()
        if tape.op[i] == ADD:
            nodes += [tape.a[i], tape.b[i]]
        elif not (tape.op[i] == MUL and tape.a[i] == tape.b[i]):
            return False
    return True


_UNARY: dict[int, Callable[[Tape, Scalar, Scalar], Scalar]] = {
    CODES["sin"]: lambda tape, x, v: tape.cos(x),
    CODES["cos"]: lambda tape, x, v: -tape.sin(x),
    CODES["tan"]: lambda tape, x, v: 1 + v * v,
    CODES["asin"]: lambda tape, x, v: 1 / tape.sqrt(1 - x * x),
    CODES["acos"]: lambda tape, x, v: -1 / tape.sqrt(1 - x * x),
    CODES["atan"]: lambda tape, x, v: 1 / (1 + x * x),
    CODES["sinh"]: lambda tape, x, v: tape.apply("cosh", x),
    CODES["cosh"]: lambda tape, x, v: tape.apply("sinh", x),
    CODES["tanh"]: lambda tape, x, v: 1 - v * v,
    CODES["sqrt"]: _slope_of_root,
    CODES["exp"]: lambda tape, x, v: v,
    CODES["log"]: lambda tape, x, v: 1 / x,
    CODES["abs"]: lambda tape, x, v: tape.apply("sign", x),
    CODES["sign"]: lambda tape, x, v: 0,
}
