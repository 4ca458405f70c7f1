"""(d) The first minute: importing, from ``fb.System()`` to a finished gyroscope trajectory, and compiling each loop.

Every figure comes from a process of its own. "cold" has an empty cache folder (the first run ever), "unseen" a cache
that holds what is common to all models but not this one, "seen" a cache that holds this model too. Modules are
byte-compiled, as an installation leaves them.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
from typing import Any

from .tables import show, time_text

IMPORT = "import time; t = time.perf_counter(); import freebody; print(time.perf_counter() - t)"

GYROSCOPE = """
import sys, time
import freebody as fb
variant = sys.argv[1]
if "imported" in sys.argv:
    fb.System, fb.disk, fb.simulate
begin = time.perf_counter()
s = fb.System("gyroscope")
m, R, L, g, d = s.parameters(m=1.2, R=0.06, L=0.1, g=9.81, d=0.0)
s.gravity = (0, 0, -g)
rotor = s.body("rotor", fb.disk(m, R, axis="z"))
psi, theta, phi = s.coordinates("psi theta phi")
s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate=(psi, theta, phi))
if variant == "other":
    s.generalized_force(theta, -d * theta.diff(s.t))
if variant == "third":
    s.generalized_force(psi, -d * psi.diff(s.t))
trajectory = fb.simulate(s, until=10, initial={"theta": 1.0471975511965976, "phi'": 300.0}, tolerance=1e-10)
trajectory["theta"]
done = time.perf_counter()
print(done - begin)
"""


COMMAND = """
import sys, time
begin = time.perf_counter()
from freebody.cli import main
sys.argv = ["freebody", "run", "gyroscope"]
try:
    main()
except SystemExit:
    pass
print(time.perf_counter() - begin)
"""

LOOP = """
import sys, time
from freebody.motion.ode.loops import functions
from freebody.native import loop
begin = time.perf_counter()
if sys.argv[1] == "moreau":
    loop.code("motion.moreau.moreau", "march")
elif sys.argv[1] == "gauss_newton":
    loop.code("motion.start.gauss_newton", "close")
elif " lanes " in sys.argv[1]:
    from freebody.motion.lanes.loops import function
    method, _, lanes = sys.argv[1].split()
    function(method, int(lanes))
else:
    functions(sys.argv[1])
print(time.perf_counter() - begin)
"""
LOOPS = {
    "dop853": "dop853", "dop54": "dop54", "radau": "radau", "gauss": "gauss", "taylor": "taylor",
    "structure": "structure", "dop853 lanes 1": "lanes of dop853", "radau lanes 1": "lanes of radau",
    "dop853 lanes 8": "lanes of dop853, eight at once", "taylor lanes 8": "lanes of taylor, eight at once",
    "gauss_newton": "start of a closed loop", "moreau": "time stepping",
}  # fmt: skip

TITLES = {
    "import": "import freebody",
    "cold": "gyroscope, first run ever (empty caches)",
    "unseen": "gyroscope with a damper, a model not seen before",
    "seen": "the same again",
    "cold, imported": "first run ever, in a process that has imported what fb.simulate needs",
    "unseen, imported": "a model not seen before, in such a process",
    "seen, imported": "a model seen before, in such a process",
    "command, cold": "freebody run gyroscope (with events), first run ever",
    "command": "freebody run gyroscope again",
}
GOALS = {"import": "< 1 s", "cold": "< 6 s", "unseen": "< 1.5 s", "seen": "< 0.3 s"}


def run(code: str, folder: str, *arguments: str) -> tuple[float, float]:
    """(seconds that the code printed, wall time of the process) with ``folder`` as every cache."""
    import time

    environment = dict(os.environ, FREEBODY_CACHE=os.path.join(folder, "freebody"))
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    paths = [path for path in sys.path if path]
    environment["PYTHONPATH"] = os.pathsep.join([os.getcwd(), *paths])
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], env=environment, capture_output=True, text=True, check=False
    )
    wall = time.perf_counter() - start
    if done.returncode:
        raise RuntimeError(f"the measured process failed:\n{done.stderr[-2000:]}")
    return float(done.stdout.split()[-1]), wall


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit
    repeats = 1 if quick else max(1, min(3, repeats))
    samples: dict[str, list[tuple[float, float]]] = {name: [] for name in TITLES}
    with tempfile.TemporaryDirectory() as folder:  # leaves the byte code of all that is measured
        run(COMMAND, folder)
        run(GYROSCOPE, folder, "plain")
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            samples["import"].append(run(IMPORT, folder))
            samples["cold"].append(run(GYROSCOPE, folder, "plain"))
            samples["unseen"].append(run(GYROSCOPE, folder, "other"))
            samples["seen"].append(run(GYROSCOPE, folder, "other"))
            samples["seen, imported"].append(run(GYROSCOPE, folder, "other", "imported"))
            samples["unseen, imported"].append(run(GYROSCOPE, folder, "third", "imported"))
        with tempfile.TemporaryDirectory() as folder:
            samples["cold, imported"].append(run(GYROSCOPE, folder, "plain", "imported"))
        with tempfile.TemporaryDirectory() as folder:
            samples["command, cold"].append(run(COMMAND, folder))
            samples["command"].append(run(COMMAND, folder))
    rows: list[list[Any]] = []
    for name, values in samples.items():
        inside, wall = (statistics.median(column) for column in zip(*values, strict=True))
        rows.append([TITLES[name], time_text(inside), GOALS.get(name, ""), time_text(wall)])
    show(
        "From fb.System() to a finished 10 s trajectory at tolerance 1e-10",
        ["", "time", "goal", "whole process"],
        rows,
        [
            "Spin 300 rad/s, let go from rest at 60°. The whole process includes starting Python and all imports."
        ],
    )
    seconds = []
    for name, title in LOOPS.items():
        taken = []
        for _ in range(repeats):
            with tempfile.TemporaryDirectory() as folder:
                taken.append(run(LOOP, folder, name)[0])
        seconds.append([title, time_text(statistics.median(taken))])
    show("First use of a compiled loop, with empty caches", ["", "time"], seconds, [])
