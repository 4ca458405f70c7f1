"""Closed-form solutions to check algorithms against. This package imports no algorithm that it checks.

torque-free bodies      :func:`torque_free` (any body, attitude too), :func:`torque_free_symmetric`
heavy tops              :func:`top` (any spin and start), :func:`asymptotic_top`
gyroscopes              :func:`gyroscope_moments`, :func:`steady_precession`, :func:`least_spin`,
                        :func:`sleeping_spin`, :func:`top_from_rest`, :func:`precession_response`
bodies on shafts        :func:`bearing_forces`, :func:`tilted_product`, :func:`tilted_axial`, :func:`dumbbell_product`
gyroscopic effects      :func:`small_oscillation`, :func:`wheel_torque`, :func:`curve_lean`, :func:`pitching_moment`,
                        :func:`transverse_spin`
rotors                  :func:`jeffcott`, :func:`jeffcott_start`, :func:`gyrocompass`, :func:`monorail`,
                        :func:`monorail_speed`
spacecraft              :func:`wheel_turn`, :func:`platform_turn`, :func:`yo_yo`, :func:`cat_turn`,
                        :func:`cat_bend`, :func:`sink_rates`
planar machines         :func:`pendulum`, :func:`pendulum_period`, :func:`hinged_bar`, :func:`cart_and_bar`,
                        :func:`double_pendulum`, :func:`double_pendulum_frequencies`,
                        :func:`struck_bar`, :func:`door_frequency`, :func:`disk_pendulum`,
                        :func:`airfoil`, :func:`airfoil_motion`, :func:`folding_links`, :func:`folding_equilibrium`
sliding and tipping     :func:`sliding_body`, :func:`leaning_board`, :func:`braking_car`, :func:`monorail_car`
joints under load       :func:`friction_circle`, :func:`jamming_arm`
surfaces                :func:`drifting_block`, :func:`dome_exit`, :func:`rolling_ball`, :func:`spinning_ball`
impacts                 :func:`elastic_impact`, :func:`damped_impact`, :func:`hunt_crossley_restitution`
rolling and leaving     :func:`pulled_disk`, :func:`rolling_down`, :func:`bar_in_cylinder`, :func:`disk_off_ledge`,
                        :func:`bar_on_ledge`, :func:`disk_in_cylinder`, :func:`falling_bar`
loads                   :func:`fall_with_drag`, :func:`fall_in_syrup`, :func:`motor_start`, :func:`kepler_orbit`,
                        :func:`libration_frequency`, :func:`steady_turn`, :func:`bushing_moment`, :func:`cable_jump`
Euler's disk            :func:`euler_disk_turn`, :func:`euler_disk_energy`, :func:`euler_disk_end`, :func:`rolling_disk`
"""

from __future__ import annotations

from .bushing import bushing_moment
from .cable import CableJump, cable_jump
from .compliant import CompliantImpact, damped_impact, elastic_impact, hunt_crossley_restitution
from .contact import (
    BrakingCar,
    LeaningBoard,
    MonorailCar,
    PulledDisk,
    RollingDown,
    SlidingBody,
    braking_car,
    friction_circle,
    jamming_arm,
    leaning_board,
    monorail_car,
    pulled_disk,
    rolling_down,
    sliding_body,
)
from .coupled import airfoil, airfoil_motion, folding_equilibrium, folding_links
from .drag import Fall, fall_in_syrup, fall_with_drag
from .euler_disk import RollingDisk, euler_disk_end, euler_disk_energy, euler_disk_turn, rolling_disk
from .falling import (
    BarInCylinder,
    BarOnLedge,
    DiskInCylinder,
    DiskOffLedge,
    FallingBar,
    bar_in_cylinder,
    bar_on_ledge,
    disk_in_cylinder,
    disk_off_ledge,
    falling_bar,
)
from .gyroscope import (
    PrecessionResponse,
    TopMotion,
    gyroscope_moments,
    least_spin,
    precession_response,
    sleeping_spin,
    small_oscillation,
    steady_precession,
    top_from_rest,
)
from .heavy_top import TopPath, asymptotic_top, top
from .hinged import disk_pendulum, door_frequency, struck_bar
from .motor import MotorStart, motor_start
from .orbit import Kepler, kepler_orbit, libration_frequency
from .planar import (
    CartAndBar,
    DoublePendulum,
    HingedBar,
    cart_and_bar,
    double_pendulum,
    double_pendulum_frequencies,
    hinged_bar,
)
from .rigid_body import Cones, TorqueFreeMotion
from .rotor import gyrocompass, jeffcott, jeffcott_start, monorail, monorail_speed
from .shaft import bearing_forces, dumbbell_product, tilted_axial, tilted_product
from .spacecraft import cat_bend, cat_turn, platform_turn, sink_rates, wheel_turn, yo_yo
from .spinning import curve_lean, pitching_moment, transverse_spin, wheel_torque
from .surfaces import (
    DriftingBlock,
    Stopping,
    dome_exit,
    drifting_block,
    rolling_ball,
    spinning_ball,
)
from .swing import pendulum, pendulum_period
from .torque_free import SymmetricMotion, torque_free, torque_free_symmetric
from .tyre import SteadyTurn, steady_turn

__all__ = [
    "BarInCylinder",
    "BarOnLedge",
    "BrakingCar",
    "CableJump",
    "CartAndBar",
    "CompliantImpact",
    "Cones",
    "DiskInCylinder",
    "DiskOffLedge",
    "DoublePendulum",
    "DriftingBlock",
    "Fall",
    "FallingBar",
    "HingedBar",
    "Kepler",
    "LeaningBoard",
    "MonorailCar",
    "MotorStart",
    "PrecessionResponse",
    "PulledDisk",
    "RollingDisk",
    "RollingDown",
    "SlidingBody",
    "SteadyTurn",
    "Stopping",
    "SymmetricMotion",
    "TopMotion",
    "TopPath",
    "TorqueFreeMotion",
    "airfoil",
    "airfoil_motion",
    "asymptotic_top",
    "bar_in_cylinder",
    "bar_on_ledge",
    "bearing_forces",
    "braking_car",
    "bushing_moment",
    "cable_jump",
    "cart_and_bar",
    "cat_bend",
    "cat_turn",
    "curve_lean",
    "damped_impact",
    "disk_in_cylinder",
    "disk_off_ledge",
    "disk_pendulum",
    "dome_exit",
    "door_frequency",
    "double_pendulum",
    "double_pendulum_frequencies",
    "drifting_block",
    "dumbbell_product",
    "elastic_impact",
    "euler_disk_end",
    "euler_disk_energy",
    "euler_disk_turn",
    "fall_in_syrup",
    "fall_with_drag",
    "falling_bar",
    "folding_equilibrium",
    "folding_links",
    "friction_circle",
    "gyrocompass",
    "gyroscope_moments",
    "hinged_bar",
    "hunt_crossley_restitution",
    "jamming_arm",
    "jeffcott",
    "jeffcott_start",
    "kepler_orbit",
    "leaning_board",
    "least_spin",
    "libration_frequency",
    "monorail",
    "monorail_car",
    "monorail_speed",
    "motor_start",
    "pendulum",
    "pendulum_period",
    "pitching_moment",
    "platform_turn",
    "precession_response",
    "pulled_disk",
    "rolling_ball",
    "rolling_disk",
    "rolling_down",
    "sink_rates",
    "sleeping_spin",
    "sliding_body",
    "small_oscillation",
    "spinning_ball",
    "steady_precession",
    "steady_turn",
    "struck_bar",
    "tilted_axial",
    "tilted_product",
    "top",
    "top_from_rest",
    "torque_free",
    "torque_free_symmetric",
    "transverse_spin",
    "wheel_torque",
    "wheel_turn",
    "yo_yo",
]
