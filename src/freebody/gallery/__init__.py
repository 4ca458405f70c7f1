"""Systems that can be run by name: ``freebody run gyroscope``, or

    >>> from freebody.gallery import entries
    >>> entries()["sec-6-9"].name
    'gyroscope'

Each module describes its machine through the public API and lets the library derive every answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .entry import Entry, Outcome

__all__ = ["Entry", "Outcome", "entries"]


class Gallery(Mapping[str, Entry]):
    """Entries by name, in order; an alias finds its entry but is not listed."""

    def __init__(self, *listed: Entry) -> None:
        self._listed = {entry.name: entry for entry in listed}
        self._found = {alias: entry for entry in listed for alias in (entry.name, *entry.aliases)}

    def __getitem__(self, name: str) -> Entry:
        return self._found[name]

    def __contains__(self, name: object) -> bool:
        return name in self._found

    def __iter__(self) -> Iterator[str]:
        return iter(self._listed)

    def __len__(self) -> int:
        return len(self._listed)


def entries() -> Gallery:
    """All entries, by name or alias."""
    from .cart_and_bar import CART_AND_BAR
    from .double_pendulum import DOUBLE_PENDULUM
    from .gyroscope import GYROSCOPE
    from .hinged_bar import HINGED_BAR
    from .torque_free import TORQUE_FREE
    from .tumbling_body import TUMBLING_BODY

    return Gallery(GYROSCOPE, TORQUE_FREE, HINGED_BAR, CART_AND_BAR, DOUBLE_PENDULUM, TUMBLING_BODY)
