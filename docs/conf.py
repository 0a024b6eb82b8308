"""Sphinx configuration: `sphinx-build -W docs docs/_build`."""

from importlib.metadata import version as installed_version

project = "pellucid"
author = "The pellucid developers"
copyright = "2026, The pellucid developers"
release = installed_version("pellucid")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
autodoc_typehints = "signature"
default_role = "code"
autodoc_member_order = "bysource"
html_theme = "furo"
html_title = f"pellucid {release}"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
