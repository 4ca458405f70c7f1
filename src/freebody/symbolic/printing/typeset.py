"""Display in notebooks: formulas set as on a page, or LaTeX where a notebook wants that."""

from __future__ import annotations

LONGEST = 30_000
"""Most characters of LaTeX that a notebook shows set; longer results it gets as LaTeX alone."""


class Typeset:
    """A result with ``latex`` that notebooks show."""

    def latex(self) -> str:
        """Return the result as LaTeX."""
        raise NotImplementedError

    def html(self) -> str:
        """Return the result as HTML that needs no other file: outlines of letters, lines that wrap.

        A screen reader reads the formulas in words; ``data-tex`` holds the LaTeX of each.
        """
        from ...typesetting.html import (
            block,  # outlines of letters take time to import, and most results are text
        )

        return block(self.latex())

    def _repr_latex_(self) -> str | None:
        return f"$\\displaystyle {self.latex()}$"

    def _repr_html_(self) -> str | None:
        tex = self._repr_latex_()
        return None if tex is None or len(tex) > LONGEST else self.html()
