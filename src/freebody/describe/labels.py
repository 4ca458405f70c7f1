"""Text by which the parts of a description appear: their kind and the user's name."""

from __future__ import annotations

import re
from typing import Any, ClassVar


class Named:
    """A part with a name; its text is its kind and that name."""

    name: Any

    def __repr__(self) -> str:
        return f"{re.sub('(?<=[a-z])(?=[A-Z])', ' ', type(self).__name__).lower()} '{self.name}'"


class OfBody:
    """A part that is fixed in a body; its text is its kind and that body."""

    body: Any
    kind: ClassVar[str]

    def __repr__(self) -> str:
        return f"the {self.kind} of {self.body!r}"
