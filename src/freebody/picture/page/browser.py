"""A headless Chromium, driven over a pipe, that opens pages of this library, takes pictures of them and prints them.

Films need it, and reports as PDF.

It speaks the DevTools protocol without a driver, a web socket, or a port that other programs could reach.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from select import select
from time import monotonic
from typing import Any

from ...errors import FreebodyError

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
"""Names of the program, in the order in which they are tried."""

FLAGS = (
    "--headless", "--disable-gpu", "--hide-scrollbars", "--no-first-run", "--disable-extensions",
    "--disable-background-networking", "--disable-sync", "--mute-audio", "--remote-debugging-pipe",
)  # fmt: skip

PATIENCE = 60.0
"""Longest wait for an answer of the browser [s]."""


def chromium() -> str | None:
    """Path of Chromium or Chrome: the program that FREEBODY_BROWSER names, or the first of `NAMES`; None if missing."""
    name = os.environ.get("FREEBODY_BROWSER")
    if name:
        return shutil.which(name)
    return next((path for path in map(shutil.which, NAMES) if path), None)


class Browser:
    """A headless browser with one page; use it in a ``with`` block.

    Parameters
    ----------
    width, height : int
        Size of the page [pixels].

    Raises
    ------
    FreebodyError
        If no Chromium is found, or it does not answer.
    """

    domains: tuple[str, ...] = ("Page", "Runtime")
    """Parts of the DevTools protocol whose events the browser sends."""

    def __init__(self, width: int = 1000, height: int = 700) -> None:
        program = chromium()
        if program is None:
            raise FreebodyError(
                f"Expected a Chromium or Chrome on this machine, found none of {', '.join(NAMES)}. Install one, or "
                "name it in the environment variable FREEBODY_BROWSER."
            )
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        # the browser reads commands from its file 3 and writes answers to its file 4
        self._read, answers = os.pipe()
        commands, self._write = os.pipe()
        self._unread, self._number = b"", 0
        root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        command = [program, *FLAGS, *root, f"--user-data-dir={self._folder.name}", "about:blank"]
        # a shell moves the pipes to the numbers that the browser expects
        moved = f'exec 3<&{commands} 4>&{answers}; exec "$@"'
        self._process = subprocess.Popen(
            ["/bin/bash", "-c", moved, "browser", *command],
            pass_fds=(commands, answers),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(answers)
        os.close(commands)
        self._session: str | None = None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in self.domains:
            self.ask(f"{domain}.enable")
        self.ask(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the browser."""
        os.close(self._write)
        os.close(self._read)
        try:
            self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._folder.cleanup()

    # -- the protocol ---------------------------------------------------------------------------------------

    def ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command of the DevTools protocol and return its answer."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        data = json.dumps(message).encode("utf-8") + b"\0"
        try:
            while data:
                data = data[os.write(self._write, data) :]
        except BrokenPipeError:
            raise FreebodyError("The browser ended too early.") from None
        while True:
            answer = self._next(method)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise FreebodyError(f"The browser refused {method}: {answer['error'].get('message')}")
                return dict(answer["result"])
            self.event(answer)

    def event(self, message: dict[str, Any]) -> None:
        """Handle an event that arrives before an answer; here it is ignored."""

    def _next(self, method: str) -> dict[str, Any]:
        """Return the next message of the browser, which is to answer ``method``."""
        deadline = monotonic() + PATIENCE
        while b"\0" not in self._unread:
            ready, _, _ = select([self._read], [], [], max(0.0, deadline - monotonic()))
            if not ready:
                raise FreebodyError(f"The browser did not answer {method} within {PATIENCE:g} s.")
            data = os.read(self._read, 1 << 20)
            if not data:
                raise FreebodyError(f"The browser ended before it answered {method}.")
            self._unread += data
        text, _, self._unread = self._unread.partition(b"\0")
        return dict(json.loads(text))

    # -- a page ---------------------------------------------------------------------------------------------

    def open(self, address: str | Path) -> None:
        """Open a file or an address and wait until the page is complete and, if it is one of ours, has begun."""
        self.ask("Page.navigate", url="about:blank")
        self.ask("Page.navigate", url=address.resolve().as_uri() if isinstance(address, Path) else address)
        begun = "(!document.getElementById('scene') || document.documentElement.dataset.begun)"
        self.wait(f"document.readyState === 'complete' && location.href !== 'about:blank' && {begun}")

    def value(self, expression: str) -> Any:
        """Return the value of a JavaScript expression in the page; for a promise, its result."""
        answer = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise FreebodyError(
                f"The page failed at {expression!r}: {details.get('exception', {}).get('description', details['text'])}"
            )
        return answer["result"].get("value")

    def wait(self, condition: str, patience: float = PATIENCE) -> None:
        """Wait until a JavaScript expression is true in the page."""
        deadline = monotonic() + patience
        while not self.value(f"new Promise(r => setTimeout(() => r(!!({condition})), 20))"):
            if monotonic() > deadline:
                raise FreebodyError(f"In the page, {condition!r} did not become true within {patience:g} s.")

    def picture(self, **options: Any) -> bytes:
        """Return the page as PNG; ``options`` as for ``Page.captureScreenshot``."""
        answer = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=True, **options)
        return base64.b64decode(answer["data"])

    def pdf(self) -> bytes:
        """Return the page as it is printed, as PDF."""
        answer = self.ask("Page.printToPDF", printBackground=True, preferCSSPageSize=True)
        return base64.b64decode(answer["data"])
