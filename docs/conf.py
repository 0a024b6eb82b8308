"""Sphinx configuration: `sphinx-build docs docs/_build`."""

from importlib.metadata import version as installed_version

project = "pellucid"
author = "The pellucid developers"
copyright = "2026, The pellucid developers"
release = installed_version("pellucid")

extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
html_theme = "alabaster"
html_theme_options = {"description": "Membranes, fluids and soft tissue with particles", "page_width": "1100px"}
