"""The machine and the values that an analysis is asked about."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from time import monotonic
from typing import TYPE_CHECKING, Any

from ...errors import FreebodyError, ModelError, TooManyTermsError, nearest
from .deadline import OutOfTimeError, within
from .section import Section

if TYPE_CHECKING:
    from ...symbolic.equations import Equations
    from ...symbolic.solving.vocabulary import Vocabulary


class Inquiry:
    """What an analysis is asked about: a machine, values, an operating point, and the time for symbolic answers."""

    def __init__(
        self,
        system: Any,
        values: dict[str, float],
        about: dict[str, float],
        start: dict[str, Any],
        near: dict[str, Any],
        patience: float | None,
    ) -> None:
        from ...motion.contact.equations_at_start import equations

        options: dict[str, Any] = {}
        if system.contacts:
            options = {"initial": start, "near": near, "values": values}
        self.e: Equations = equations(system, **options)
        self.model = self.e.model
        self.overrides = values
        self.about = about
        self.near = near
        self.deadline = None if patience is None else monotonic() + patience
        self.patience = patience
        self.missing = [p.name for p in self.model.parameters if p.default is None and p.name not in values]
        self.values = {} if self.missing else dict(self.model.values(values))
        names = self.model.state_names
        for name in about:
            if name not in names:
                raise ModelError(
                    f"--about {name}: expected a coordinate or a speed of '{self.model.name}', got '{name}'; "
                    f"{nearest(name, names)}"
                )
        self.start = {} if self.missing else {name: self._number(name, x) for name, x in start.items()}

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """Names of symbols in text and LaTeX."""
        from ...symbolic.solving.vocabulary import Vocabulary

        return Vocabulary(self.e)

    def _number(self, name: str, value: Any) -> float:
        from ...motion.start.initial import number

        return number(self.model, self.values, value, f"the initial value of '{name}'")

    def in_symbols(self, title: str, question: Callable[[], Section]) -> Section:
        """Return the answer, or a section with the reason why there is none."""
        try:
            with within(self.deadline):
                return question()
        except OutOfTimeError:
            return Section(title, notes=[self.out_of_time("Not found")])
        except TooManyTermsError as error:
            return Section(title, notes=[str(error)])

    def out_of_time(self, what: str) -> str:
        """End the time for symbolic answers, since the next questions need the same equations; return a note."""
        self.deadline = float(0)
        return (
            f"{what} in {self.patience:g} s: the symbolic answer is large. Allow more time with --patience."
        )

    def show(self, expression: Any) -> str:
        """Return a SymPy expression or relation as plain text."""
        if getattr(expression, "is_Relational", False):
            return f"{self._arranged(expression.lhs)} {expression.rel_op} {self._arranged(expression.rhs)}"
        return self.vocabulary.name(expression)

    def _arranged(self, expression: Any) -> str:
        """Text of a SymPy expression, arranged as equations are if the ring has it."""
        from ...symbolic.printing.closed.answers import shown
        from ...symbolic.printing.text import Text

        try:
            element = self.vocabulary.ring.from_sympy(expression)
        except FreebodyError:
            return self.vocabulary.name(expression)
        return str(shown(Text, element, self.vocabulary.ring, closed=False))

    def no_numbers(self) -> str:
        """Return the note that parameters without a value leave no answer in numbers."""
        names = ", ".join(self.missing)
        return f"No numbers, since no value is given for {names}. Add --set {self.missing[0]}=VALUE."

    def at(self) -> str:
        """Return the values of all parameters as text."""
        return ", ".join(f"{name} = {value:.6g}" for name, value in self.values.items())

    def symbol(self, name: str) -> Any:
        """Return the SymPy symbol of a name."""
        import sympy

        return self.vocabulary.names.get(name, sympy.Symbol(name, real=True))
