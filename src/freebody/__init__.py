"""Rigid-body dynamics from the free-body diagram to the equation, the number and the picture.

    import freebody as fb

    s = fb.System("pendulum")            # describe the machine once
    fb.equations(s)                      # its free-body equations and equations of motion
    fb.simulate(s, until=10)             # its motion, to a stated tolerance

A public name is imported from its module when it is first used, so that ``import freebody`` costs
a few milliseconds and nobody pays for the compiler or the plots of a product that was not asked for.
"""

from __future__ import annotations

from functools import partial
from importlib import import_module
from types import FunctionType
from typing import TYPE_CHECKING, Any

from . import rooms_above as _rooms_above
from .unreachable import no_collection
from .version import VERSION as __version__

if TYPE_CHECKING:
    from . import errors as errors
    from . import exact as exact
    from . import testing as testing
    from .describe.body import Body as Body
    from .describe.contacts.gap import Gap as Gap
    from .describe.frame import Point as Point
    from .describe.joints.ball import Ball as Ball
    from .describe.joints.hinge import Hinge as Hinge
    from .describe.joints.joint import Joint as Joint
    from .describe.joints.rotor import Rotor as Rotor
    from .describe.joints.screw import Screw as Screw
    from .describe.joints.slider import Slider as Slider
    from .describe.loads.action import Couple as Couple
    from .describe.loads.action import GeneralizedForce as GeneralizedForce
    from .describe.loads.action import JointForce as JointForce
    from .describe.loads.action import PointForce as PointForce
    from .describe.loads.load import Load as Load
    from .describe.loads.load import Look as Look
    from .describe.shapes.shape import ContactShape as ContactShape
    from .describe.shapes.shape import Nearest as Nearest
    from .describe.signal import signal as signal
    from .describe.system import System as System
    from .dynamics.conditions.unilateral import MotionWarning as MotionWarning
    from .errors import FreebodyError as FreebodyError
    from .formats import read as read
    from .formats import write as write
    from .model.assemble import assemble as assemble
    from .model.model import Model as Model
    from .motion.contact.course import timeline as timeline
    from .motion.contact.equations_at_start import equations as equations
    from .motion.legs.blow import blow as blow
    from .motion.legs.impulse import centre_of_percussion as centre_of_percussion
    from .motion.legs.impulse import impulse as impulse
    from .motion.ode.tableau import RungeKutta as RungeKutta
    from .motion.start.on_floor import on_floor as on_floor
    from .motion.trajectory.event import event as event
    from .motion.trajectory.trajectory import Trajectory as Trajectory
    from .picture.free_body.free_body_diagram import free_body_diagram as free_body_diagram
    from .picture.machine.draw import draw as draw
    from .picture.page.report import report as report
    from .picture.plots import plot as plot
    from .picture.plots.compare_linear import compare_linear as compare_linear
    from .program.program import compile_system as compile  # noqa: F401
    from .scalar.algebra import Expression as Expression
    from .scalar.algebra import Vector as Vector
    from .space.density import from_density as from_density
    from .space.density import revolve as revolve
    from .space.mass import MassProperties as MassProperties
    from .space.mesh import mesh as mesh
    from .space.pose import Pose as Pose
    from .space.rotation import Rotation as Rotation
    from .space.solids import box as box
    from .space.solids import cone as cone
    from .space.solids import cylinder as cylinder
    from .space.solids import disk as disk
    from .space.solids import ellipsoid as ellipsoid
    from .space.solids import particle as particle
    from .space.solids import plate as plate
    from .space.solids import ring as ring
    from .space.solids import slender_bar as slender_bar
    from .space.solids import sphere as sphere
    from .space.solids import spherical_shell as spherical_shell
    from .space.solids import torus as torus
    from .space.solids import tube as tube
    from .studies.fit import fit as fit
    from .studies.identification import identify as identify
    from .studies.lanes.grid import grid as grid
    from .studies.lanes.sample import sample as sample
    from .studies.lanes.table import table as table
    from .studies.open_study import open_study as open_study
    from .studies.reducers.extremes import largest as largest
    from .studies.reducers.extremes import smallest as smallest
    from .studies.reducers.histogram import histogram as histogram
    from .studies.reducers.mean import mean as mean
    from .studies.reducers.quantile import quantile as quantile
    from .studies.reducers.stopping import error as error
    from .studies.reducers.variance import covariance as covariance
    from .studies.reducers.variance import variance as variance
    from .studies.simulate import simulate as simulate
    from .studies.study import Study as Study
    from .studies.study import study as study
    from .studies.sweep import sweep as sweep
    from .symbolic.inertia.base_parameters import base_parameters as base_parameters
    from .symbolic.linear.linearize import linearize as linearize
    from .symbolic.printing import component_forms as forms  # noqa: F401
    from .symbolic.rotors.balancing import balance as balance
    from .symbolic.rotors.bearings import bearing_reactions as bearing_reactions
    from .symbolic.steady.steady import steady_motions as steady_motions

# public name -> its module; "module:attribute" if the attribute has another name, "module:" if it is the module
_EXPORTS = {
    "Ball": "describe.joints.ball",
    "Body": "describe.body",
    "ContactShape": "describe.shapes.shape",
    "Couple": "describe.loads.action",
    "Expression": "scalar.algebra",
    "FreebodyError": "errors",
    "Gap": "describe.contacts.gap",
    "GeneralizedForce": "describe.loads.action",
    "Hinge": "describe.joints.hinge",
    "Joint": "describe.joints.joint",
    "JointForce": "describe.loads.action",
    "Load": "describe.loads.load",
    "Look": "describe.loads.load",
    "MassProperties": "space.mass",
    "Model": "model.model",
    "MotionWarning": "dynamics.conditions.unilateral",
    "Nearest": "describe.shapes.shape",
    "Point": "describe.frame",
    "PointForce": "describe.loads.action",
    "Pose": "space.pose",
    "Rotation": "space.rotation",
    "Rotor": "describe.joints.rotor",
    "RungeKutta": "motion.ode.tableau",
    "Screw": "describe.joints.screw",
    "Slider": "describe.joints.slider",
    "System": "describe.system",
    "Trajectory": "motion.trajectory.trajectory",
    "Vector": "scalar.algebra",
    "assemble": "model.assemble",
    "balance": "symbolic.rotors.balancing",
    "base_parameters": "symbolic.inertia.base_parameters",
    "bearing_reactions": "symbolic.rotors.bearings",
    "blow": "motion.legs.blow",
    "box": "space.solids",
    "centre_of_percussion": "motion.legs.impulse",
    "compare_linear": "picture.plots.compare_linear",
    "compile": "program.program:compile_system",
    "cone": "space.solids",
    "covariance": "studies.reducers.variance",
    "cylinder": "space.solids",
    "disk": "space.solids",
    "draw": "picture.machine.draw",
    "ellipsoid": "space.solids",
    "equations": "motion.contact.equations_at_start",
    "error": "studies.reducers.stopping",
    "errors": "errors:",
    "event": "motion.trajectory.event",
    "exact": "exact:",
    "fit": "studies.fit",
    "identify": "studies.identification",
    "forms": "symbolic.printing.component_forms:",
    "free_body_diagram": "picture.free_body.free_body_diagram",
    "from_density": "space.density",
    "grid": "studies.lanes.grid",
    "histogram": "studies.reducers.histogram",
    "impulse": "motion.legs.impulse",
    "largest": "studies.reducers.extremes",
    "linearize": "symbolic.linear.linearize",
    "mean": "studies.reducers.mean",
    "mesh": "space.mesh",
    "particle": "space.solids",
    "plate": "space.solids",
    "plot": "picture.plots.plot:",
    "quantile": "studies.reducers.quantile",
    "read": "formats",
    "report": "picture.page.report",
    "revolve": "space.density",
    "ring": "space.solids",
    "sample": "studies.lanes.sample",
    "signal": "describe.signal",
    "on_floor": "motion.start.on_floor",
    "open_study": "studies.open_study",
    "simulate": "studies.simulate",
    "Study": "studies.study",
    "study": "studies.study",
    "slender_bar": "space.solids",
    "smallest": "studies.reducers.extremes",
    "sphere": "space.solids",
    "spherical_shell": "space.solids",
    "steady_motions": "symbolic.steady.steady",
    "sweep": "studies.sweep",
    "table": "studies.lanes.table",
    "testing": "testing:",
    "timeline": "motion.contact.course",
    "torus": "space.solids",
    "tube": "space.solids",
    "variance": "studies.reducers.variance",
    "write": "formats",
}

__all__ = [
    *sorted(_EXPORTS),
    "__version__",
]


def __getattr__(name: str) -> Any:
    """Return a public name, imported on first use and kept in this module (PEP 562)."""
    if name in _EXPORTS:
        place, whole, attribute = _EXPORTS[name].partition(":")
        with no_collection():
            module = import_module(f"{__name__}.{place}")
        value = module if whole and not attribute else getattr(module, attribute or name)
        if isinstance(value, FunctionType) and not hasattr(value, "__wrapped__"):
            from .errors import arguments_named

            value = arguments_named(value)
            setattr(module, attribute or name, value)  # the function that pickle finds
        globals()[name] = value
        return value
    if name.startswith("__"):  # asked by tools, not by people: keep it cheap
        raise AttributeError(f"module 'freebody' has no attribute {name!r}")
    from .errors import nearest

    raise AttributeError(f"Expected a public name of freebody, got {name!r}; {nearest(name, _EXPORTS)}")


def __dir__() -> list[str]:
    return sorted({*_EXPORTS, "__version__", "__doc__", "__name__", "__file__", "__path__"})


_WORK = {
    "draw": "picture.machine.draw",
    "plots": "picture.plots.plots",
    "animate": "picture.page.animate",
    "save": "motion.files.save",
    "load": "motion.files.load",
    "batch": "studies.batch",
    "wasm": "motion.live.export",
}
for _name, _module in _WORK.items():
    _rooms_above.offer(_name, partial(import_module, f"{__name__}.{_module}"))
