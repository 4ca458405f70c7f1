"""The animation of a motion or of a mode by itself: in a notebook, as a page, or as a film."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import FreebodyError, SimulationError, path_of
from ...formats.files import replacing
from ..moving.keyframes import TOLERANCE
from ..moving.mode_motion import mode_motion
from .animation import animation, posed
from .browser import Browser, chromium
from .page import page

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory
    from ...symbolic.linear.linear_model import LinearModel

SWITCHES = ("trails", "frames", "names", "forces", "reactions", "cones", "follow", "repeat")
"""Names of what an animation can show from its beginning."""

MOST = 2000
"""Most frames of a film."""


def animate(
    trajectory: Trajectory, *, tolerance: float = TOLERANCE, height: int = 520, **shown: bool
) -> Animation:
    """Return a motion as an animation.

    Parameters
    ----------
    trajectory : Trajectory
    tolerance : float
        Tolerance of the interpolation between keyframes.
    height : int
        Height of the player in a notebook [pixels].
    **shown : bool
        Show from the beginning ``trails``, ``frames``, ``names``, ``forces``, ``reactions``, ``cones``; ``follow`` the
        machine; ``repeat`` the motion.

    Returns
    -------
    Animation
        Notebooks show it; ``.save(path)`` writes ``.html``, ``.gif`` or ``.mp4``.

    Raises
    ------
    SimulationError
        If a switch is unknown.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    >>> s.gravity = (0, -9.81, 0)
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
    >>> fb.simulate(s, until=2, initial={"theta": 1}).animate(forces=True)
    Animation of 'pendulum', 0 to 2 s
    """
    span = trajectory.path.start, trajectory.path.end
    return Animation(
        trajectory.name, span, lambda: animation(trajectory, tolerance), height, _switches(shown)
    )


def animate_mode(
    linear: LinearModel, mode: int = 0, *, amplitude: float | None = None, height: int = 520, **shown: bool
) -> Animation:
    """Return the motion of a machine in one of its modes as an animation; see `LinearModel.animate`."""
    keys = mode_motion(linear, mode, amplitude)
    title = f"{linear.model.name}, mode {mode}"

    def scene() -> dict[str, Any]:
        return posed(linear.model, linear.values, keys, title)

    return Animation(title, (0.0, float(keys.t[-1])), scene, height, _switches(shown))


def _switches(shown: Mapping[str, bool]) -> dict[str, bool]:
    for name in shown:
        if name not in SWITCHES:
            raise SimulationError(f"Expected one of {', '.join(SWITCHES)} to show, got '{name}'.")
    return {name: bool(value) for name, value in shown.items()}


class Animation:
    """An animation, made by :meth:`freebody.Trajectory.animate` and by `animate` of linear equations.

    Attributes
    ----------
    html : str
        The page: one HTML document that makes no request.
    """

    def __init__(
        self,
        title: str,
        span: tuple[float, float],
        scene: Callable[[], dict[str, Any]],
        height: int,
        shown: dict[str, bool],
    ) -> None:
        self.title, self.span = title, span
        self._scene = scene
        self.height = height
        self.shown = shown

    @cached_property
    def html(self) -> str:
        """The page: one HTML document that makes no request."""
        scene = self._scene()
        scene["shown"] = self.shown
        return page(self.title, scene, '<div id="player"></div>', bare=True)

    def _repr_html_(self) -> str:
        # in a frame of its own, its script and style do not meet those of the notebook
        return (
            f'<iframe sandbox="allow-scripts" srcdoc="{escape(self.html)}" '
            f'style="width:100%;height:{int(self.height)}px;box-sizing:border-box;border:1px solid #d6d9de;'
            'border-radius:6px"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Animation of '{self.title}', {self.span[0]:g} to {self.span[1]:g} s"

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        fps: float = 25,
        speed: float = 1,
        width: int = 720,
        height: int = 480,
    ) -> Path:
        """Write the animation to a file, whole or not at all.

        Parameters
        ----------
        path : path
            ``.html``, ``.gif`` (with Pillow) or ``.mp4`` (with ffmpeg). A headless Chromium draws the films.
        fps : float
            Frames per second of the film.
        speed : float
            Seconds of the motion per second of the film.
        width, height : int
            Size of the film [pixels].

        Raises
        ------
        SimulationError
            If the file name has another ending, or the film has too many frames.
        FreebodyError
            If a program that the film needs is missing.
        """
        target = path_of(path, "an animation", SimulationError)
        kind = target.suffix.lower()
        if kind not in (".html", ".gif", ".mp4"):
            raise SimulationError(f"Expected a file that ends in .html, .gif or .mp4, got '{target.name}'.")
        if kind == ".html":
            with replacing(target) as new:
                new.write_text(self.html, encoding="utf-8")
            return target
        _check_tools(kind)
        start, end = sorted(self.span)
        if not (fps > 0 and speed > 0):
            raise SimulationError(f"Expected fps and speed above 0, got fps = {fps:g} and speed = {speed:g}.")
        count = max(2, round((end - start) / speed * fps) + 1)
        if count > MOST:
            raise SimulationError(
                f"Expected a film of at most {MOST} frames, but {end - start:g} s at {fps:g} frames per second and "
                f"speed {speed:g} makes {count}. Raise speed=, lower fps=, or write .html."
            )
        times = [start + (end - start) * i / (count - 1) for i in range(count)]
        with replacing(target) as new, tempfile.TemporaryDirectory() as folder:
            # video codecs need even sizes
            files = self._frames(Path(folder), times, width + width % 2, height + height % 2)
            (_gif if kind == ".gif" else _mp4)(files, new, fps)
        return target

    def _frames(self, folder: Path, times: list[float], width: int, height: int) -> list[Path]:
        """Write a PNG of the page at each time; return the files."""
        source = folder / "film.html"
        source.write_text(self.html, encoding="utf-8")
        files = []
        with Browser(width, height) as browser:
            browser.open(source)
            browser.value("document.body.classList.add('film')")
            # wait for two animation frames, so that the picture is that of the time
            ready = "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))"
            browser.value(ready)
            for i, t in enumerate(times):
                browser.value(f"freebody.seek({t!r}); {ready}")
                files.append(folder / f"{i:05d}.png")
                files[-1].write_bytes(browser.picture())
        return files


def _check_tools(kind: str) -> None:
    """Raise if a program that a film needs is missing."""
    missing = []
    if chromium() is None:
        missing.append("a Chromium or Chrome, which draws the frames")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        missing.append("ffmpeg, which joins them")
    if missing:
        raise FreebodyError(
            f"Writing {kind} needs {' and '.join(missing)}; not found on this machine. Install it, or write .html, "
            "which needs nothing."
        )


def _gif(files: list[Path], target: Path, fps: float) -> None:
    from PIL import Image

    first, *rest = [Image.open(file).convert("P", palette=Image.Palette.ADAPTIVE) for file in files]
    first.save(target, format="GIF", save_all=True, append_images=rest, duration=round(1000 / fps), loop=0)


def _mp4(files: list[Path], target: Path, fps: float) -> None:
    command = [
        "ffmpeg", "-y", "-loglevel", "error", "-framerate", f"{fps:g}", "-i", str(files[0].parent / "%05d.png"),
        "-pix_fmt", "yuv420p", "-f", "mp4", str(target),
    ]  # fmt: skip
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        raise SimulationError(f"ffmpeg could not write '{target.name}': {result.stderr.strip()[-300:]}")
