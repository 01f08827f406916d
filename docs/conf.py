"""Settings of the documentation site: `make docs` builds it with Sphinx, warnings are errors."""

from importlib.metadata import version as installed_version

project = "rallygap"
author = "the authors of rallygap"
release = version = installed_version("rallygap")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]
exclude_patterns = ["_build"]

# Markdown: headings are link targets, and `colon_fence` sets directives apart from code.
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]

# Python: Google docstrings, types in the signature, members in the order of the source.
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"rallygap {release}"
