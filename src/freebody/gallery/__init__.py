"""Systems that can be run by name: ``freebody run gyroscope``, or

    >>> from freebody.gallery import entries
    >>> entries()["gyroscope"].name
    'sec-6-9'

Each module describes its machine through the public API, and the library derives every answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .tools.answer import Answer, Check
from .tools.entry import Entry, Outcome

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
        """All names under which entries are found, aliases included."""
        return tuple(self._found)


def entries() -> Gallery:
    """Return all entries by name or alias."""
    from .beyond.block_and_tackle import BLOCK_AND_TACKLE
    from .beyond.bouncing_ball import BOUNCING_BALL
    from .beyond.control_moment_gyro import CONTROL_MOMENT_GYRO
    from .beyond.drives.bevel_gears import BEVEL_GEARS
    from .beyond.drives.planetary_gear import PLANETARY_GEAR
    from .beyond.drives.turning_car import TURNING_CAR
    from .beyond.drives.two_gears import TWO_GEARS
    from .beyond.drives.worm_gear import WORM_GEAR
    from .beyond.energy_sink import ENERGY_SINK
    from .beyond.euler_disk import EULER_DISK
    from .beyond.falling_cat import FALLING_CAT
    from .beyond.flat_spin import FLAT_SPIN
    from .beyond.four_bar import FOUR_BAR
    from .beyond.gyro_monorail import GYRO_MONORAIL
    from .beyond.gyrocompass import GYROCOMPASS
    from .beyond.jeffcott import JEFFCOTT
    from .beyond.precession_paths import PRECESSION_PATHS
    from .beyond.rattleback import RATTLEBACK
    from .beyond.reaction_wheel import REACTION_WHEEL
    from .beyond.rocking_block import ROCKING_BLOCK
    from .beyond.rolling_disk import ROLLING_DISK
    from .beyond.sleeping_top import SLEEPING_TOP
    from .beyond.slider_crank import SLIDER_CRANK
    from .beyond.swing import SWING
    from .beyond.tippe_top import TIPPE_TOP
    from .beyond.tumbling_body import TUMBLING_BODY
    from .beyond.turntable import TURNTABLE
    from .beyond.whipple_bicycle import WHIPPLE_BICYCLE
    from .beyond.yo_yo import YO_YO
    from .textbook.examples.ex_6_1_sliding_body import SLIDING_BODY
    from .textbook.examples.ex_6_2_hinged_bar import HINGED_BAR
    from .textbook.examples.ex_6_3_pulled_disk import PULLED_DISK
    from .textbook.examples.ex_6_4_rolling_down import ROLLING_DOWN
    from .textbook.examples.ex_6_5_cart_and_bar import CART_AND_BAR
    from .textbook.examples.sec_6_6_tilted_disk import TILTED_DISK
    from .textbook.examples.sec_6_8_torque_free import TORQUE_FREE
    from .textbook.examples.sec_6_9_gyroscope import GYROSCOPE
    from .textbook.examples.sec_6_10_nutation import NUTATION
    from .textbook.problems.prob_6_1_board_on_truck import BOARD_ON_TRUCK
    from .textbook.problems.prob_6_2_braking_car import BRAKING_CAR
    from .textbook.problems.prob_6_3_monorail import MONORAIL
    from .textbook.problems.prob_6_4_percussion import PERCUSSION
    from .textbook.problems.prob_6_5_door import DOOR
    from .textbook.problems.prob_6_6_disk_pendulum import DISK_PENDULUM
    from .textbook.problems.prob_6_7_bar_in_cylinder import BAR_IN_CYLINDER
    from .textbook.problems.prob_6_8_disk_on_ledge import DISK_ON_LEDGE
    from .textbook.problems.prob_6_9_bar_on_ledge import BAR_ON_LEDGE
    from .textbook.problems.prob_6_10_disk_in_cylinder import DISK_IN_CYLINDER
    from .textbook.problems.prob_6_11_falling_bar import FALLING_BAR
    from .textbook.problems.prob_6_12_dumbbell import DUMBBELL
    from .textbook.problems.prob_6_13_cylinder_on_shaft import CYLINDER_ON_SHAFT
    from .textbook.problems.prob_6_14_airfoil import AIRFOIL
    from .textbook.problems.prob_6_15_double_pendulum import DOUBLE_PENDULUM
    from .textbook.problems.prob_6_16_two_links import TWO_LINKS
    from .textbook.problems.prob_6_17_satellite import SATELLITE
    from .textbook.problems.prob_6_18_motorcycle import MOTORCYCLE
    from .textbook.problems.prob_6_19_turboprop import TURBOPROP
    from .textbook.problems.prob_6_20_projectile import PROJECTILE
    from .textbook.problems.prob_6_21_struck_gyroscope import STRUCK_GYROSCOPE

    return Gallery(
        SLIDING_BODY, HINGED_BAR, PULLED_DISK, ROLLING_DOWN, CART_AND_BAR, TILTED_DISK, TORQUE_FREE,
        GYROSCOPE, NUTATION, BOARD_ON_TRUCK, BRAKING_CAR, MONORAIL, PERCUSSION, DOOR, DISK_PENDULUM,
        BAR_IN_CYLINDER, DISK_ON_LEDGE, BAR_ON_LEDGE, DISK_IN_CYLINDER, FALLING_BAR, DUMBBELL,
        CYLINDER_ON_SHAFT, AIRFOIL, DOUBLE_PENDULUM, TWO_LINKS, SATELLITE, MOTORCYCLE, TURBOPROP,
        PROJECTILE, STRUCK_GYROSCOPE, TUMBLING_BODY, ROLLING_DISK, FOUR_BAR, SLIDER_CRANK, TWO_GEARS,
        BLOCK_AND_TACKLE, WHIPPLE_BICYCLE, GYROCOMPASS, JEFFCOTT, REACTION_WHEEL, CONTROL_MOMENT_GYRO,
        YO_YO, ENERGY_SINK, FALLING_CAT, PRECESSION_PATHS, FLAT_SPIN, SLEEPING_TOP, GYRO_MONORAIL, SWING,
        BOUNCING_BALL, ROCKING_BLOCK, TURNTABLE, TIPPE_TOP, RATTLEBACK, EULER_DISK, BEVEL_GEARS, WORM_GEAR,
        PLANETARY_GEAR, TURNING_CAR,
    )  # fmt: skip
