"""How parts of a description show themselves: by the names that the user gave."""

from __future__ import annotations

import re
from typing import Any


class Named:
    """What has a name, and shows itself as its kind and that name."""

    name: Any

    def __repr__(self) -> str:
        return f"{re.sub('(?<=[a-z])(?=[A-Z])', ' ', type(self).__name__).lower()} '{self.name}'"


class OfBody:
    """What is fixed in a body, and shows itself as its kind and that body."""

    body: Any
    kind: str

    def __repr__(self) -> str:
        return f"the {self.kind} of {self.body!r}"
