"""All plots under one name: ``fb.plot.phase(trajectory, "theta")``.

    history           quantities over time, events marked           (trajectory.plot)
    phase             a coordinate against its rate
    reaction          force of a joint over time
    friction_margin   friction margin of each contact; contact_forces, contact_gaps
    energy            the energy ledger; energy_residual: its imbalance
    axis_path         path of a body axis on the unit sphere
    polhode           path of the angular velocity on the energy ellipsoid
    cones             the body cone on the space cone
    instant_centres   instant centres of a planar machine at one time
    velocity_diagram  velocities of its joints from one pole; acceleration_diagram
    coupler_curves    paths of points of a planar machine, with the machine
    section_forces    normal force, shear force and bending moment along a bar
    mode_shapes       mode shapes of linear equations
    root_locus        eigenvalues along a parameter
    campbell          natural frequencies of a rotor over its speed, with whirl sense and critical speeds
    bifurcation       steady motions along a parameter
    lanes             results of a study: numbers against what varies, bands over time

Each function returns matplotlib axes, and draws into the axes ``ax=`` if given; nothing opens a window.
"""

from __future__ import annotations

from .campbell_diagram import campbell
from .cones import cones
from .contact_plots import contact_forces, contact_gaps, friction_margin
from .lane_plots import lanes
from .linear_plots import bifurcation, mode_shapes, root_locus
from .planar_kinematics import acceleration_diagram, coupler_curves, instant_centres, velocity_diagram
from .plots import energy, energy_residual, history, phase, reaction
from .section_forces import section_forces
from .sphere import axis_path, polhode

__all__ = [
    "acceleration_diagram",
    "axis_path",
    "bifurcation",
    "campbell",
    "cones",
    "contact_forces",
    "contact_gaps",
    "coupler_curves",
    "energy",
    "energy_residual",
    "friction_margin",
    "history",
    "instant_centres",
    "lanes",
    "mode_shapes",
    "phase",
    "polhode",
    "reaction",
    "root_locus",
    "section_forces",
    "velocity_diagram",
]
