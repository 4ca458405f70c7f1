"""The base class of results that print themselves."""

from __future__ import annotations


class Result:
    """A result with ``text``, ``latex`` and ``mathml``; notebooks show its LaTeX, a console its text."""

    def text(self) -> str:
        """Return the result as plain text."""
        raise NotImplementedError

    def latex(self) -> str:
        """Return the result as LaTeX."""
        raise NotImplementedError

    def mathml(self) -> str:
        """Return the result as presentation MathML."""
        raise NotImplementedError

    def _repr_latex_(self) -> str | None:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()
