"""Size and time of the report, of diagrams, and of a change in the live page; frames a second of the animation.

two bodies       cart and bar, 20 s, bounds of the project: 1.5 MB
gyroscope        one body, 10 s of the gallery's own run
many bodies      50 boxes that fall and turn, 5 s: frames a second in a Chromium that renders in software
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import freebody as fb
from freebody.gallery import entries
from freebody.picture.page.animation import animation
from freebody.picture.page.browser import Browser, chromium

from .tables import seconds, time_text

HEAD = f"{'':28}{'simulate':>12}{'report':>12}{'size':>12}{'keyframes':>12}"


def two_bodies() -> tuple[Any, Any]:
    """A cart on a spring with a hinged bar."""
    s = fb.System("cart_and_bar")
    M, m, a, k, g = s.parameters(M=2.0, m=1.0, a=0.5, k=50.0, g=9.81)
    s.gravity = (0, -g, 0)
    cart = s.body("cart", fb.particle(M))
    bar = s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bar, to=(0, a, 0), axis="z", coordinate="theta")
    s.spring("spring", guide, stiffness=k)
    return s, lambda: fb.simulate(s, 20, initial={"theta": "60deg"})


def disk() -> tuple[Any, Any]:
    """A disk that bounces, and rolls in the end."""
    s = fb.System("bouncing_disk")
    m, R, mu, g = s.parameters(m=1, R=0.3, mu=0.2, g=9.81)
    s.gravity = (0, -g, 0)
    body = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, body, coordinate="x y phi")
    s.contact("floor", body.circle(R), s.ground.plane(), friction=mu, restitution=0.7)
    return s, lambda: fb.simulate(s, 20, initial={"y": 1.3, "x'": 2})


def many(count: int) -> tuple[Any, Any]:
    """Boxes that are thrown, each with its own spin."""
    s = fb.System("boxes")
    s.gravity = (0, 0, -9.81)
    start: dict[str, float] = {}
    for i in range(count):
        s.free(f"j{i}", s.ground, s.body(f"b{i}", fb.box(1, (0.3, 0.2, 0.1))))
        start |= {f"j{i}_x": 0.5 * (i % 10), f"j{i}_y": 0.5 * (i // 10), f"j{i}_vz": 20 + 0.1 * i}
        start |= {f"j{i}_wx": 0.01, f"j{i}_wy": 3.0 + 0.05 * i}
    return s, lambda: fb.simulate(s, 4, initial=start, tolerance=1e-6)


def frames(path: Path, patience: float = 4.0) -> float:
    """Frames a second of a page that plays, arrows of forces switched on."""
    with Browser(1000, 800) as browser:
        browser.open(f"{path.as_uri()}#forces=1&play=1")
        before, start = browser.value("freebody.state.drawn"), time.perf_counter()
        time.sleep(patience)
        drawn = browser.value("freebody.state.drawn") - before
        return float(drawn / (time.perf_counter() - start))


def main(quick: bool = False, repeats: int = 5, limit: float = 0.0) -> None:
    """Print the table."""
    del limit
    print("Report\n\n" + HEAD)
    gyroscope = entries()["gyroscope"].run()
    cases: dict[str, tuple[Any, Any]] = {
        "two bodies, 20 s": two_bodies(),
        "bouncing disk, 20 s": disk(),
        "gyroscope": (gyroscope.system, lambda: gyroscope.trajectory),
        f"{10 if quick else 50} boxes, 4 s": many(10 if quick else 50),
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "report.html")
        for name, (s, simulate) in cases.items():
            motion = simulate()
            ran = seconds(simulate, repeats) if name != "gyroscope" else None

            def write(s: Any = s, motion: Any = motion) -> None:
                fb.report(s, motion, path)

            took = seconds(write, 1 if "boxes" in name else repeats)
            keys = len(animation(motion)["t"]) * 3 // 16  # base64 of 32-bit floats
            size = f"{path.stat().st_size / 1e6:.3f} MB"
            print(f"{name:28}{time_text(ran):>12}{time_text(took):>12}{size:>12}{keys:>12}")
            if "boxes" in name:
                shown = f"{frames(path):.0f} frames/s" if chromium() else "no browser here"
                print(f"{'  played, software renderer':28}{shown:>24}")
        s, _ = two_bodies()
        e = fb.equations(s)
        fb.free_body_diagram(e, "bar")
        took = seconds(lambda: fb.free_body_diagram(e, "bar"), repeats)
        print(f"{'diagram, equations given':28}{time_text(took):>24}")
        _live(repeats)
    print()


def _live(repeats: int) -> None:
    """A slider moved: new motion, and the data of the page."""
    from freebody.formats.case import Case
    from freebody.picture.page.live import Live

    for name in ("gyroscope", "double-pendulum"):
        entry = entries()[name]
        live = Live(Case(entry.build(), dict(entry.start), entry.until, None, dict(entry.near)))
        live.machine()
        parameter = live.model.parameters[0].name
        value = live.values[parameter]
        took = seconds(lambda p=parameter, x=value, v=live: v.motion({p: 1.01 * x}, {}, v.until), repeats)
        print(f"{'slider, ' + name:28}{time_text(took):>24}")
