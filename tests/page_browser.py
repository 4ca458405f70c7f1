"""The browser of the package for tests of pages: it records requests and errors, and has a mouse."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from freebody.picture.page.browser import Browser


class PageBrowser(Browser):
    """A headless browser with one page; use it in a ``with`` block.

    Attributes
    ----------
    requests : list of str
        Addresses that the page requested, its own included; data in the page itself (``data:``) is no request.
    errors : list of str
        Uncaught errors of the page, and requests or scripts that its policy or the browser refused.
    """

    domains = (*Browser.domains, "Network", "Log")

    def __init__(self, width: int = 1000, height: int = 700) -> None:
        self.requests: list[str] = []
        self.errors: list[str] = []
        super().__init__(width, height)

    def __enter__(self) -> PageBrowser:
        return self

    def event(self, message: dict[str, Any]) -> None:
        """Record requests and errors."""
        parameters = message.get("params", {})
        if message.get("method") == "Network.requestWillBeSent":
            url = parameters["request"]["url"]
            if not url.startswith(("data:", "about:")):
                self.requests.append(url)
        elif message.get("method") == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details.get("text", "error")))
        elif message.get("method") == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.errors.append(parameters["entry"]["text"])

    def open(self, address: str | Path) -> None:
        """Open a file or an address and wait until the page is complete; forget earlier requests and errors."""
        self.ask("Page.navigate", url="about:blank")
        self.requests.clear()
        self.errors.clear()
        super().open(address)

    def element(self, selector: str) -> bytes:
        """Return the first element that a selector finds as PNG."""
        box = self.value(
            f"(b => ({{x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height}}))"
            f"(document.querySelector({json.dumps(selector)}).getBoundingClientRect())"
        )
        return self.picture(clip={**box, "scale": 1})

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Send a mouse event: ``pressed``, ``released``, ``moved`` or ``wheel`` at a point [pixels]."""
        name = {"wheel": "mouseWheel"}.get(kind, f"mouse{kind.capitalize()}")
        self.ask("Input.dispatchMouseEvent", type=name, x=x, y=y, **more)

    def press(self, x: float, y: float) -> None:
        """Click with the left button."""
        for kind in ("pressed", "released"):
            self.mouse(kind, x, y, button="left", clickCount=1)
