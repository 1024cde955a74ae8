"""The site of planarc: `sphinx-build -W -n docs docs/_build`."""

from __future__ import annotations

import sys
from pathlib import Path

from planarc.core.version import __version__

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "planarc"
author = "the authors of planarc"
release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "planarc_docs"]
exclude_patterns = ["_build", "_ext", "made"]

suppress_warnings = ["misc.highlighting_failure"]  # of models that shall be wrong

html_theme = "furo"
html_title = "planarc"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Docstrings are plain text in which names stand in backticks.
default_role = "code"
smartquotes = False  # `--option` is no dash
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
nitpick_ignore_regex = [
    # Types of signatures: of other packages, and those that users do not meet by name.
    (r"py:(class|obj|data|mod)", r"(?!planarc\.\w+$).*"),
]
