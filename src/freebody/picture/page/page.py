"""A page that opens offline: one HTML file, whose own policy lets no request leave it.

The policy names the page's one script by its SHA-256 and nothing else, so that a script that came in with a name or a
title would not run, if ever one got past the escaping.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any

SCRIPTS = (
    "geometry.js",
    "solids.js",
    "renderer.js",
    "motion.js",
    "ornaments.js",
    "charts.js",
    "timeline.js",
    "player.js",
    "page.js",
)
"""Files of the folder ``page`` that make the page's script, in this order."""

LIVE = (*SCRIPTS[:-1], "live.js")
"""Those of the live page."""


@cache
def script(names: tuple[str, ...] = SCRIPTS) -> str:
    """The script of a page."""
    folder = files(__package__)
    parts = [(folder / name).read_text(encoding="utf-8").replace('"use strict";\n', "", 1) for name in names]
    return "(() => {\n" + '"use strict";\n' + "\n".join(parts) + "})();\n"


@cache
def style() -> str:
    """The style sheet of the page."""
    return (files(__package__) / "page.css").read_text(encoding="utf-8")


def policy(text: str, connect: str = "") -> str:
    """The content policy of a page with one script: no request (but to ``connect``), no other script.

    >>> policy("alert()").split("; ")[0]
    "default-src 'none'"
    """
    digest = base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
    requests = f"connect-src {connect}; " if connect else ""
    return (
        f"default-src 'none'; script-src 'sha256-{digest}'; {requests}style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )


def embedded(data: Mapping[str, Any]) -> str:
    """Data as JSON that can stand in a script element, whatever texts it holds.

    >>> embedded({"name": "</script><b>"})
    '{"name":"\\\\u003c/script\\\\u003e\\\\u003cb\\\\u003e"}'
    """
    text = json.dumps(data, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def page(title: str, scene: Mapping[str, Any], body: str, *, bare: bool = False, live: bool = False) -> str:
    """A whole HTML document.

    Parameters
    ----------
    title : str
        Plain text; it is escaped.
    scene : mapping
        Of :func:`freebody.picture.page.animation.animation`.
    body : str
        HTML, with an element ``id="player"`` and, where charts shall stand, elements ``data-chart="0"`` and so on
        inside of ``details``.
    bare : bool
        Whether the player fills the window.
    live : bool
        Whether it is the page of ``freebody view``, which asks the server that it came from, and no other.
    """
    code = script(LIVE if live else SCRIPTS)
    allowed = policy(code, "'self'" if live else "")
    attribute = ' class="bare"' if bare else ""
    return (
        "<!DOCTYPE html>\n"
        '<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{escape(allowed)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style()}</style>\n</head>\n"
        f"<body{attribute}>\n<main>\n{body}\n</main>\n"
        f'<script type="application/json" id="scene">{embedded(scene)}</script>\n'
        f"<script>{code}</script>\n</body>\n</html>\n"
    )
