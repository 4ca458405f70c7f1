"""A Chromium without a window, driven over a pipe: it opens pages of this library, takes pictures of them, and leaves.

Only what the DevTools protocol needs: no driver, no web socket, no port that others could reach.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from select import select
from time import monotonic
from types import TracebackType
from typing import Any

from ...errors import FreebodyError

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--headless", "--disable-gpu", "--hide-scrollbars", "--no-first-run", "--disable-extensions",
    "--disable-background-networking", "--disable-sync", "--mute-audio", "--remote-debugging-pipe",
)  # fmt: skip
PATIENCE = 60.0
"""Longest wait for an answer of the browser [s]."""


def chromium() -> str | None:
    """The path of a Chromium or Chrome, or of the one that FREEBODY_BROWSER names; None if there is none."""
    named = os.environ.get("FREEBODY_BROWSER")
    if named:
        return shutil.which(named)
    return next((found for found in map(shutil.which, NAMES) if found), None)


class Browser:
    """A headless browser with one page; use it in a ``with`` block.

    Parameters
    ----------
    width, height : int
        Of the page [pixels].

    Attributes
    ----------
    requests : list of str
        Addresses that the page asked for, its own included; what it holds itself (``data:``) is no request.
    errors : list of str
        What went wrong in the page: uncaught errors, and what its policy or the browser refused.

    Raises
    ------
    FreebodyError
        No Chromium is found, or it does not answer.
    """

    def __init__(self, width: int = 1000, height: int = 700) -> None:
        program = chromium()
        if program is None:
            raise FreebodyError(
                f"Expected a Chromium or Chrome on this machine, found none of {', '.join(NAMES)}. Install one, or "
                "name it in the environment variable FREEBODY_BROWSER."
            )
        self.requests: list[str] = []
        self.errors: list[str] = []
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        # the browser reads commands from its file 3 and writes answers to its file 4
        ours_in, theirs_out = os.pipe()
        theirs_in, ours_out = os.pipe()
        self._read, self._write = ours_in, ours_out
        self._rest, self._number = b"", 0
        root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        command = [program, *FLAGS, *root, f"--user-data-dir={self._folder.name}", "about:blank"]
        # a shell moves the pipes to the numbers that the browser expects
        moved = f'exec 3<&{theirs_in} 4>&{theirs_out}; exec "$@"'
        self._process = subprocess.Popen(
            ["/bin/bash", "-c", moved, "browser", *command],
            pass_fds=(theirs_in, theirs_out),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._session: str | None = None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
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
        """Send a command of the DevTools protocol and wait for its answer."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        data = json.dumps(message).encode("utf-8") + b"\0"
        try:
            while data:
                data = data[os.write(self._write, data) :]
        except BrokenPipeError:
            raise FreebodyError("The browser ended before it was asked to.") from None
        while True:
            answer = self._next(method)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise FreebodyError(f"The browser refused {method}: {answer['error'].get('message')}")
                return dict(answer["result"])
            self._event(answer)

    def _next(self, waiting: str) -> dict[str, Any]:
        until = monotonic() + PATIENCE
        while b"\0" not in self._rest:
            ready, _, _ = select([self._read], [], [], max(0.0, until - monotonic()))
            if not ready:
                raise FreebodyError(f"The browser did not answer {waiting} within {PATIENCE:g} s.")
            more = os.read(self._read, 1 << 20)
            if not more:
                raise FreebodyError(f"The browser ended while it was asked for {waiting}.")
            self._rest += more
        text, _, self._rest = self._rest.partition(b"\0")
        return dict(json.loads(text))

    def _event(self, message: Mapping[str, Any]) -> None:
        given = message.get("params", {})
        if message.get("method") == "Network.requestWillBeSent":
            if not given["request"]["url"].startswith("data:"):  # which the page itself holds
                self.requests.append(given["request"]["url"])
        elif message.get("method") == "Runtime.exceptionThrown":
            details = given["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details.get("text", "error")))
        elif message.get("method") == "Log.entryAdded" and given["entry"]["level"] == "error":
            self.errors.append(given["entry"]["text"])

    # -- a page ---------------------------------------------------------------------------------------------

    def open(self, address: str | Path) -> None:
        """Open a file or an address and wait until the page is complete."""
        self.ask("Page.navigate", url="about:blank")
        url = address.resolve().as_uri() if isinstance(address, Path) else address
        self.requests.clear()
        self.errors.clear()
        self.ask("Page.navigate", url=url)
        self.wait("document.readyState === 'complete' && location.href !== 'about:blank'")

    def value(self, expression: str) -> Any:
        """The value of a JavaScript expression in the page; of a promise, what it gives."""
        found = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            details = found["exceptionDetails"]
            raise FreebodyError(
                f"The page failed at {expression!r}: {details.get('exception', {}).get('description', details['text'])}"
            )
        return found["result"].get("value")

    def wait(self, condition: str, patience: float = PATIENCE) -> None:
        """Wait until an expression is true in the page."""
        until = monotonic() + patience
        while not self.value(f"new Promise(r => setTimeout(() => r(!!({condition})), 20))"):
            if monotonic() > until:
                raise FreebodyError(f"The page did not come to {condition!r} within {patience:g} s.")

    def picture(self, selector: str | None = None) -> bytes:
        """The page, or the first element that a selector finds, as PNG."""
        options: dict[str, Any] = {"format": "png", "captureBeyondViewport": True}
        if selector is not None:
            box = self.value(
                f"(b => ({{x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height}}))"
                f"(document.querySelector({json.dumps(selector)}).getBoundingClientRect())"
            )
            options["clip"] = {**box, "scale": 1}
        return base64.b64decode(self.ask("Page.captureScreenshot", **options)["data"])

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """A mouse event in the page: ``pressed``, ``released``, ``moved`` or ``wheel`` at a place [pixels]."""
        name = {"wheel": "mouseWheel"}.get(kind, f"mouse{kind.capitalize()}")
        self.ask("Input.dispatchMouseEvent", type=name, x=x, y=y, **more)

    def press(self, x: float, y: float) -> None:
        """A click with the left button."""
        for kind in ("pressed", "released"):
            self.mouse(kind, x, y, button="left", clickCount=1)
