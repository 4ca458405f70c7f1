"""Algorithms of rigid-body dynamics, generic over the scalar, one file per idea."""

from .articulated import forward_dynamics
from .composite import mass_matrix
from .coriolis import coriolis_matrix, gravity_forces
from .energy import kinetic_energy, mechanical_power, potential_energy
from .kinematics import coordinate_rates, jacobian, poses
from .momentum import momentum
from .newton_euler import bias, inverse_dynamics, reactions
from .state import State, float_state, polynomial_state, rest_coordinates, traced_state

__all__ = [
    "State",
    "bias",
    "coordinate_rates",
    "coriolis_matrix",
    "float_state",
    "forward_dynamics",
    "gravity_forces",
    "inverse_dynamics",
    "jacobian",
    "kinetic_energy",
    "mass_matrix",
    "mechanical_power",
    "momentum",
    "polynomial_state",
    "poses",
    "potential_energy",
    "reactions",
    "rest_coordinates",
    "traced_state",
]
