"""The terms of the project: one word for each thing, with its symbol, its unit and the place that computes it.

``python docs/_ext/glossary.py`` writes ``docs/glossary.md`` from this table; a test checks that the page is up to date and
that each place exists.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

DOCS = Path(__file__).resolve().parents[1]


class Term(NamedTuple):
    """A term; ``place`` is a file under ``src/freebody`` and a function, class or constant in it."""

    name: str
    symbol: str
    unit: str
    meaning: str
    place: str


MACHINES = [
    Term("machine", "", "", "mechanism of the user: bodies, joints, loads, contacts", "describe/system.py:System"),
    Term("system", "`s`", "", "description of a machine; the only object that changes", "describe/system.py:System"),
    Term("model", "", "", "assembled machine: frozen and checked", "model/assemble.py:assemble"),
    Term("body", "", "", "rigid body of a system", "describe/body.py:Body"),
    Term("link", "", "", "body of a model with the joint that carries it", "model/parts.py:Link"),
    Term("ground", "`N`", "", "inertial frame with axes X, Y, Z", "model/parts.py:GROUND"),
    Term("joint", "", "", "connection that leaves a child body some freedom relative to its parent", "describe/joints/joint.py:Joint"),
    Term("armature", "`A`", "kg m²", "inertia that the speed of a joint alone moves", "dynamics/armature.py:resistance"),
    Term("rotor", "`J`, `n`", "kg m²", "part of a motor that a joint turns through a gear", "describe/joints/rotor.py:Rotor"),
    Term("load", "", "", "force or couple that acts on bodies, such as a spring's", "describe/loads/load.py:Load"),
    Term("parameter", "", "", "symbol with a default value", "describe/description.py:Parameter"),
    Term("feature", "", "", "point, edge or surface of a body that can touch another", "describe/shapes/plane.py:Plane"),
    Term("constraint", "", "", "restriction of the motion besides the joints of the tree", "describe/constraints/constraint.py:Constraint"),
    Term("condition", "", "", "scalar equation of a constraint or a closed contact", "dynamics/conditions/constraints.py:Row"),
    Term("closed loop", "", "", "joints that connect a body to the ground in more than one way", "model/closure.py:Closure"),
]  # fmt: skip
DYNAMICS = [
    Term("coordinate", "q", "m, rad", "quantity that fixes a part of the configuration", "model/parts.py:Coordinate"),
    Term("speed", "u", "m/s, rad/s", "generalized speed; u = q' except for ball and free joints", "model/parts.py:Speed"),
    Term("state", "(q, u)", "", "coordinates, then speeds", "dynamics/state.py:State"),
    Term("mass", "m", "kg", "mass of a body", "space/mass.py:MassProperties"),
    Term("inertia", "I", "kg m²", "matrix of inertia about a point, off the diagonal minus the integrals", "space/mass.py:MassProperties"),
    Term("products of inertia", "I_xy", "kg m²", "integrals ∫ x y dm", "space/mass.py:Products"),
    Term("mass matrix", "M", "kg, kg m²", "coefficients of u' in the equations of motion", "dynamics/composite.py:mass_matrix"),
    Term("bias", "h", "N, N m", "generalized forces needed where u' = 0", "dynamics/newton_euler.py:bias"),
    Term("reaction", "", "N, N m", "force and moment that a joint or constraint exerts on the child", "dynamics/newton_euler.py:reactions"),
    Term("redundant", "", "", "of conditions: dependent on the others", "dynamics/conditions/dependence.py:dependence"),
    Term("indeterminate", "", "", "of reactions: not fixed by the equations of rigid bodies", "dynamics/conditions/indeterminate.py:indeterminate"),
    Term("kinetic energy", "T", "J", "½ uᵀ M u", "dynamics/energy.py:kinetic_energy"),
    Term("potential energy", "V", "J", "energy of gravity, springs and potentials", "dynamics/energy.py:potential_energy"),
    Term("momentum", "p, H", "kg m/s, kg m²/s", "linear and angular momentum of bodies", "dynamics/momentum.py:momentum"),
    Term("impulse", "P", "N s", "force times time of a blow or an impact", "dynamics/impulse.py:speed_jumps"),
    Term("one-sided limit", "", "N", "zero of a force that can only pull, or only push", "dynamics/conditions/unilateral.py:Limit"),
    Term("contact mode", "", "", "open, stick, slip", "motion/events/decision.py:solved_modes"),
    Term("compliant contact", "N(d, d')", "N", "contact whose normal force is a law of its depth d", "dynamics/contact_geometry.py:normal_force"),
    Term("friction cone", "|T| <= μ N", "N", "contact forces that Coulomb's law allows", "motion/cones/contact_problem.py:ContactProblem"),
    Term("friction ellipse", "(T1/μ1)² + (T2/μ2)² <= N²", "N", "friction with two coefficients, along a direction of the surface and across it", "model/contact.py:elliptic_friction"),
    Term("adhesion", "A", "N", "pull that a closed contact bears, N >= -A", "motion/events/moment.py:adhere"),
    Term("rolling resistance", "δ", "m", "length whose product with N bounds the moment against rolling", "model/resistance.py:Resistance"),
    Term("restitution", "ε", "", "ratio of the normal speeds after and before an impact", "motion/events/impacts/impacts.py:together"),
]  # fmt: skip
FORMULAS = [
    Term("scalar", "", "", "number of any field: float, canonical polynomial, traced scalar", "scalar/algebra.py:Scalar"),
    Term("ring", "", "", "canonical polynomials with relations such as sin² + cos² = 1", "scalar/ring.py:Ring"),
    Term("conserved quantity", "", "", "function of the state whose rate is proven zero", "symbolic/integrals/conserved_quantities.py:integrals"),
    Term("ignorable coordinate", "", "", "coordinate that the Lagrangian does not contain", "symbolic/integrals/routh.py:ignorable"),
    Term("steady motion", "", "", "motion with constant speeds, equilibrium included", "symbolic/steady/steady.py:steady_motions"),
    Term("operating point", "", "", "state or motion about which equations are linearized", "symbolic/linear/operating_point.py:OperatingPoint"),
    Term("linear model", "M, C, K", "", "M x'' + C x' + K x = B f", "symbolic/linear/linear_model.py:LinearModel"),
    Term("mode shape", "", "", "eigenvector of the linear model", "symbolic/linear/modes.py:Mode"),
    Term("natural frequency", "ω", "rad/s", "imaginary part of an eigenvalue of the undamped model", "symbolic/linear/modes.py:Modes"),
]  # fmt: skip
PROGRAMS = [
    Term("trace", "", "", "to run an algorithm on scalars that record it", "scalar/trace.py:Traced"),
    Term("tape", "", "", "recorded computation", "scalar/trace.py:Tape"),
    Term("kernel", "", "", "compiled function of one state, or of eight", "program/kernels.py:compile_tape"),
    Term("program", "", "", "compiled dynamics of a machine", "program/program.py:Program"),
    Term("product", "", "", "function that a program offers, such as the mass matrix", "program/products.py:PRODUCTS"),
    Term("compiled language", "", "", "part of Python that is translated to LLVM", "native/translation.py:translated"),
]  # fmt: skip
MOTION = [
    Term("run", "", "", "call of the integrator from a start to an end or an event", "motion/ode/integration.py:Integration"),
    Term("initial values", "", "", "values of coordinates and speeds at the start", "motion/start/initial.py:initial_state"),
    Term("step-size control", "", "", "choice of the step length by an estimate of the error", "motion/ode/step_control.py:advance"),
    Term("dense output", "", "", "values between the ends of a step", "motion/ode/dense_output.py:Path"),
    Term("tolerance", "", "", "bound of the error of a step, relative to the state", "motion/ode/integration.py:Integration"),
    Term("event", "", "s", "zero of an expression of the state, located in time", "motion/ode/event_search.py:find_events"),
    Term("leg", "", "", "part of a motion between two interruptions: blow, sample, signal", "motion/legs/driven.py:driven_path"),
    Term("phase", "", "", "part of a motion with fixed contact modes", "motion/trajectory/phases.py:Phases"),
    Term("trajectory", "", "", "result of a simulation", "motion/trajectory/trajectory.py:Trajectory"),
    Term("time stepping", "", "", "method of Moreau and Jean: contact as impulses of a step", "motion/timestepping/timestepping.py:stepped_motion"),
    Term("batch", "", "", "many motions of one machine in one call", "studies/batch.py:batch"),
    Term("lane", "", "", "one motion of a batch", "motion/lanes/lanes.py:functions"),
    Term("store", "", "", "file that a batch fills lane by lane, and resumes from", "studies/stores/netcdf.py:NetCDF"),
]  # fmt: skip
PICTURES = [
    Term("sheet", "", "pt", "lines, arrows and labels on paper", "picture/paper/sheet.py:Sheet"),
    Term("drawing", "", "", "finished picture of a machine or a body", "picture/paper/drawing.py:Drawing"),
    Term("panel", "", "", "one isolated body of a free-body diagram", "picture/free_body/panel.py:Panel"),
    Term("page", "", "", "offline HTML file with animation, plots and equations", "picture/page/page.py:page"),
    Term("keyframe", "", "s", "moment at which the animation holds the poses of all bodies", "picture/moving/keyframes.py:keyframes"),
]  # fmt: skip

TERMS = {
    "Machines": MACHINES,
    "Dynamics": DYNAMICS,
    "Formulas": FORMULAS,
    "Programs": PROGRAMS,
    "Motion": MOTION,
    "Pictures": PICTURES,
}


def page() -> str:
    """The page, as Markdown."""
    parts = [
        "# Glossary\n",
        "One word for one thing, here and in the source. Files are those under `src/freebody/`.\n",
    ]
    for title, terms in TERMS.items():
        parts += [f"## {title}\n", "| term | symbol | unit | meaning | file |", "|---|---|---|---|---|"]
        for term in sorted(terms):
            file, _, name = term.place.partition(":")
            row = (term.name, term.symbol.replace("|", "\\|"), term.unit, term.meaning, f"`{file}` `{name}`")
            parts.append(f"| {' | '.join(row)} |".replace("|  |", "| |").replace("|  |", "| |"))
        parts.append("")
    return "\n".join(parts)


if __name__ == "__main__":
    (DOCS / "glossary.md").write_text(page(), encoding="utf-8")
