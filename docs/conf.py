"""Settings of the documentation: ``sphinx-build -W docs docs/_build``, offline."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

import freebody as fb  # noqa: E402

project = "freebody"
author = "The freebody authors"
copyright = "The freebody authors, MIT License"
version = release = fb.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "formulas",
    "gallery_pages",
    "reference_pages",
    "bibliography_page",
]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build", "_ext"]
myst_enable_extensions = ["colon_fence", "dollarmath"]
html_math_renderer = "freebody"
myst_heading_anchors = 3
highlight_language = "text"

autodoc_typehints = "none"  # types stand in the text, in the reader's words
autodoc_member_order = "bysource"
napoleon_use_param = False  # types are words, not links
napoleon_use_rtype = False
napoleon_use_ivar = True
nitpicky = False

html_theme = "furo"
html_title = f"freebody {version}"
html_static_path = ["_static"]
html_css_files = ["freebody.css"]
html_extra_path = ["systems/pages"]  # whole pages, shown in frames: gallery_pages makes them
(HERE / "systems" / "pages").mkdir(parents=True, exist_ok=True)
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}


def setup(app):
    """Give headings of the navigation their level, for readers of screens, and long lines of code to the keys."""
    app.connect("html-page-context", _for_everybody, priority=900)


def _for_everybody(app, page, template, context, tree):
    context["body"] = context.get("body", "").replace("<pre>", '<pre tabindex="0">')
    name = "furo_navigation_tree"
    context[name] = context.get(name, "").replace('role="heading"', 'role="heading" aria-level="2"')
