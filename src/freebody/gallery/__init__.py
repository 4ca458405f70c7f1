"""Systems that can be run by name: ``freebody run gyroscope``, or

    >>> from freebody.gallery import entries
    >>> entries()["gyroscope"].name
    'sec-6-9'

Each module describes its machine through the public API and lets the library derive every answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .answer import Answer, Check
from .entry import Entry, Outcome

__all__ = ["Answer", "Check", "Entry", "Outcome", "entries"]


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

    @property
    def names(self) -> tuple[str, ...]:
        """All names that are found, aliases too."""
        return tuple(self._found)


def entries() -> Gallery:
    """All entries, by name or alias."""
    from .airfoil import AIRFOIL
    from .bar_in_cylinder import BAR_IN_CYLINDER
    from .bar_on_ledge import BAR_ON_LEDGE
    from .block_and_tackle import BLOCK_AND_TACKLE
    from .board_on_truck import BOARD_ON_TRUCK
    from .bouncing_ball import BOUNCING_BALL
    from .braking_car import BRAKING_CAR
    from .cart_and_bar import CART_AND_BAR
    from .control_moment_gyro import CONTROL_MOMENT_GYRO
    from .cylinder_on_shaft import CYLINDER_ON_SHAFT
    from .disk_in_cylinder import DISK_IN_CYLINDER
    from .disk_on_ledge import DISK_ON_LEDGE
    from .disk_pendulum import DISK_PENDULUM
    from .door import DOOR
    from .double_pendulum import DOUBLE_PENDULUM
    from .dumbbell import DUMBBELL
    from .energy_sink import ENERGY_SINK
    from .euler_disk import EULER_DISK
    from .falling_bar import FALLING_BAR
    from .falling_cat import FALLING_CAT
    from .flat_spin import FLAT_SPIN
    from .four_bar import FOUR_BAR
    from .gyro_monorail import GYRO_MONORAIL
    from .gyrocompass import GYROCOMPASS
    from .gyroscope import GYROSCOPE
    from .hinged_bar import HINGED_BAR
    from .jeffcott import JEFFCOTT
    from .monorail import MONORAIL
    from .motorcycle import MOTORCYCLE
    from .nutation import NUTATION
    from .percussion import PERCUSSION
    from .precession_paths import PRECESSION_PATHS
    from .projectile import PROJECTILE
    from .pulled_disk import PULLED_DISK
    from .rattleback import RATTLEBACK
    from .reaction_wheel import REACTION_WHEEL
    from .rocking_block import ROCKING_BLOCK
    from .rolling_disk import ROLLING_DISK
    from .rolling_down import ROLLING_DOWN
    from .satellite import SATELLITE
    from .sleeping_top import SLEEPING_TOP
    from .slider_crank import SLIDER_CRANK
    from .sliding_body import SLIDING_BODY
    from .struck_gyroscope import STRUCK_GYROSCOPE
    from .swing import SWING
    from .tilted_disk import TILTED_DISK
    from .tippe_top import TIPPE_TOP
    from .torque_free import TORQUE_FREE
    from .tumbling_body import TUMBLING_BODY
    from .turboprop import TURBOPROP
    from .turntable import TURNTABLE
    from .two_gears import TWO_GEARS
    from .two_links import TWO_LINKS
    from .whipple_bicycle import WHIPPLE_BICYCLE
    from .yo_yo import YO_YO

    return Gallery(
        SLIDING_BODY, HINGED_BAR, PULLED_DISK, ROLLING_DOWN, CART_AND_BAR, TILTED_DISK, TORQUE_FREE,
        GYROSCOPE, NUTATION, BOARD_ON_TRUCK, BRAKING_CAR, MONORAIL, PERCUSSION, DOOR, DISK_PENDULUM,
        BAR_IN_CYLINDER, DISK_ON_LEDGE, BAR_ON_LEDGE, DISK_IN_CYLINDER, FALLING_BAR, DUMBBELL,
        CYLINDER_ON_SHAFT, AIRFOIL, DOUBLE_PENDULUM, TWO_LINKS, SATELLITE, MOTORCYCLE, TURBOPROP,
        PROJECTILE, STRUCK_GYROSCOPE, TUMBLING_BODY, ROLLING_DISK, FOUR_BAR, SLIDER_CRANK, TWO_GEARS,
        BLOCK_AND_TACKLE, WHIPPLE_BICYCLE, GYROCOMPASS, JEFFCOTT, REACTION_WHEEL, CONTROL_MOMENT_GYRO,
        YO_YO, ENERGY_SINK, FALLING_CAT, PRECESSION_PATHS, FLAT_SPIN, SLEEPING_TOP, GYRO_MONORAIL, SWING,
        BOUNCING_BALL, ROCKING_BLOCK, TURNTABLE, TIPPE_TOP, RATTLEBACK, EULER_DISK,
    )  # fmt: skip
