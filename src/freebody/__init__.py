"""Rigid-body dynamics from the free-body diagram to the equation, the number and the picture.

    import freebody as fb

    s = fb.System("pendulum")            # describe the machine once
    fb.equations(s)                      # its free-body equations and equations of motion
    fb.simulate(s, until=10)             # its motion, to a stated tolerance

A public name is imported from its module when it is first used, so that ``import freebody`` costs
a few milliseconds and nobody pays for the compiler or the plots of a product that was not asked for.
"""

from __future__ import annotations

import sys
from importlib import import_module
from time import time_ns
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import errors as errors
    from . import exact as exact
    from . import testing as testing
    from .at_start import equations as equations
    from .compile.program import compile_system as compile  # noqa: F401
    from .describe.signal import signal as signal
    from .describe.system import System as System
    from .dynamics.unilateral import MotionWarning as MotionWarning
    from .equations import component_forms as forms  # noqa: F401
    from .equations.balancing import balance as balance
    from .equations.bearings import bearing_reactions as bearing_reactions
    from .equations.linearize import linearize as linearize
    from .equations.steady import steady_motions as steady_motions
    from .errors import FreebodyError as FreebodyError
    from .formats import read as read
    from .formats import write as write
    from .model.assemble import assemble as assemble
    from .model.model import Model as Model
    from .picture import plot as plot
    from .picture.compare_linear import compare_linear as compare_linear
    from .picture.draw import draw as draw
    from .picture.free_body_diagram import free_body_diagram as free_body_diagram
    from .picture.report import report as report
    from .simulate.blow import blow as blow
    from .simulate.contact_trajectory import timeline as timeline
    from .simulate.event import event as event
    from .simulate.impulse import centre_of_percussion as centre_of_percussion
    from .simulate.impulse import impulse as impulse
    from .simulate.simulate import simulate as simulate
    from .simulate.trajectory import Trajectory as Trajectory
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
    from .study.fit import fit as fit
    from .study.sweep import sweep as sweep

__version__ = "0.1.0"
IMPORTED = time_ns()
"""When this process began to read the package [ns since 1970]."""

# public name -> module that holds it, "module:attribute" where the attribute is named otherwise
_EXPORTS = {
    "FreebodyError": "errors",
    "MassProperties": "space.mass",
    "Model": "model.model",
    "MotionWarning": "dynamics.unilateral",
    "Pose": "space.pose",
    "Rotation": "space.rotation",
    "System": "describe.system",
    "Trajectory": "simulate.trajectory",
    "assemble": "model.assemble",
    "balance": "equations.balancing",
    "bearing_reactions": "equations.bearings",
    "blow": "simulate.blow",
    "box": "space.solids",
    "centre_of_percussion": "simulate.impulse",
    "compare_linear": "picture.compare_linear",
    "compile": "compile.program:compile_system",
    "cone": "space.solids",
    "cylinder": "space.solids",
    "disk": "space.solids",
    "draw": "picture.draw",
    "ellipsoid": "space.solids",
    "equations": "at_start",
    "errors": "errors",
    "event": "simulate.event",
    "exact": "exact",
    "fit": "study.fit",
    "forms": "equations.component_forms",
    "free_body_diagram": "picture.free_body_diagram",
    "from_density": "space.density",
    "impulse": "simulate.impulse",
    "linearize": "equations.linearize",
    "mesh": "space.mesh",
    "particle": "space.solids",
    "plate": "space.solids",
    "plot": "picture.plot",
    "read": "formats",
    "report": "picture.report",
    "revolve": "space.density",
    "ring": "space.solids",
    "signal": "describe.signal",
    "simulate": "simulate.simulate",
    "slender_bar": "space.solids",
    "sphere": "space.solids",
    "spherical_shell": "space.solids",
    "steady_motions": "equations.steady",
    "sweep": "study.sweep",
    "testing": "testing",
    "timeline": "simulate.contact_trajectory",
    "torus": "space.solids",
    "tube": "space.solids",
    "write": "formats",
}

__all__ = [
    *sorted(_EXPORTS),
    "__version__",
]


def _resolve(name: str) -> Any:
    """The object of a public name, imported now and kept in this module's dictionary."""
    module_name, _, attribute = _EXPORTS[name].partition(":")
    module = import_module(f"{__name__}.{module_name}")
    value = (
        module
        if name in ("errors", "exact", "forms", "plot", "testing")
        else getattr(module, attribute or name)
    )
    globals()[name] = value
    return value


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        return _resolve(name)
    from .errors import nearest

    if name.startswith("__"):  # asked by tools, not by people: keep it cheap
        raise AttributeError(f"module 'freebody' has no attribute {name!r}")
    raise AttributeError(f"Expected a public name of freebody, got {name!r}; {nearest(name, _EXPORTS)}")


def __dir__() -> list[str]:
    return sorted({*_EXPORTS, "__version__", "__doc__", "__name__", "__file__", "__path__"})


class _Freebody(ModuleType):
    """The class of this module, in which a public function may share its name with the folder it lives in.

    Importing ``freebody.equations`` makes Python bind the folder as the attribute ``equations`` of this
    module, whichever import comes first. That binding is left out, so ``freebody.equations`` is the
    function in every order. The folder stays what ``from freebody.equations import ...`` reads.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in _BESIDE_FOLDERS or value is not sys.modules.get(f"{__name__}.{name}"):
            super().__setattr__(name, value)


_BESIDE_FOLDERS = ("compile", "equations", "simulate")


sys.modules[__name__].__class__ = _Freebody
