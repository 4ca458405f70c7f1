"""A page that opens offline: one HTML file whose content policy allows no request.

The policy allows only the script of the page, by its SHA-256. If a name or a title with a script in it ever got past
the escaping, that script would not run.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Mapping
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any

from .packing import packed
from .symbols import Symbols

SCRIPTS = (
    "formulas.js",
    "geometry.js",
    "data.js",
    "solids.js",
    "renderer.js",
    "motion.js",
    "ornaments.js",
    "charts.js",
    "timeline.js",
    "stage.js",
    "labels.js",
    "player.js",
    "page.js",
)
"""Files of the folder ``page`` whose texts, in this order, are the script of a page."""

LIVE = (*SCRIPTS[:-1], "simulator.js", "sliders.js", "page.js")
"""Files of the script of a page that computes its motion."""

VIEW = (*LIVE[:-1], "live.js")
"""Files of the script of the page of ``freebody view``."""


@cache
def script(names: tuple[str, ...] = SCRIPTS) -> str:
    """Return the script of a page, without comments and indents."""
    folder = files(__package__)
    text = "\n".join((folder / name).read_text(encoding="utf-8") for name in names)
    code = re.sub(r"^\s*(//.*|\"use strict\";)?\n|^ +", "", text, flags=re.MULTILINE)
    return "(() => {\n" + '"use strict";\n' + code + "})();\n"


@cache
def style() -> str:
    """Return the style sheet of all pages."""
    return (files(__package__) / "page.css").read_text(encoding="utf-8")


def policy(text: str, connect: str = "", compute: bool = False) -> str:
    """Return the content policy of a page with one script: no other script, no requests except to ``connect``.

    With ``compute`` the page may compile WebAssembly.

    >>> policy("alert()").split("; ")[0]
    "default-src 'none'"
    """
    digest = base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
    requests = f"connect-src {connect}; " if connect else ""
    wasm = " 'wasm-unsafe-eval'" if compute else ""
    return (
        f"default-src 'none'; script-src 'sha256-{digest}'{wasm}; {requests}style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )


def page(
    title: str,
    scene: Mapping[str, Any],
    body: str,
    *,
    bare: bool = False,
    view: bool = False,
    symbols: Symbols | None = None,
) -> str:
    """Return a whole HTML document.

    Parameters
    ----------
    title : str
        Plain text; it is escaped.
    scene : mapping
        Data from :func:`freebody.picture.page.animation.animation`.
    body : str
        HTML with an element ``id="player"``, and with an element ``data-chart="0"`` and so on inside ``details`` for
        each chart. If the scene has the data ``live`` of a simulator: also with the elements of :func:`stage`.
    bare : bool
        Let the player fill the window.
    view : bool
        Return the page of ``freebody view``, which sends requests to its own server only.
    symbols : Symbols, optional
        The symbols of the formulas in the body.
    """
    live = view or "live" in scene
    symbols = symbols or Symbols()
    scene = scene if view else symbols.scene(scene)
    code = script(VIEW if view else LIVE if live else SCRIPTS)
    allowed = policy(code, "'self'" if view else "", live)
    attribute = ' class="bare"' if bare else ""
    return (
        "<!DOCTYPE html>\n"
        '<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{escape(allowed)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style()}</style>\n</head>\n"
        f"<body{attribute}>\n{symbols.table()}<main>\n{body}\n</main>\n"
        f'<script type="application/octet-stream" id="scene">{packed(scene)}</script>\n'
        f"<script>{code}</script>\n</body>\n</html>\n"
    )


def stage(live: bool) -> str:
    """Return the HTML of the player, with a place for sliders beside it if the page is live.

    >>> stage(False)
    '<div id="player"></div>'
    """
    if not live:
        return '<div id="player"></div>'
    return (
        '<div class="live">\n<section><div id="player"></div></section>\n'
        '<aside><h2>Values</h2><p id="problem" role="status" hidden></p><div id="sliders"></div>'
        '<p><button id="reset" type="button" hidden>Reset</button> <span id="work"></span></p></aside>\n</div>'
    )
