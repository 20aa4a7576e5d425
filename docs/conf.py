"""How the documentation is built: `sphinx-build -W --keep-going docs build/site`."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "ext"))

project = "dubins-study"
author = "The dubins-study authors"
project_copyright = "The dubins-study authors, MIT licence"
release = version = installed_version("dubins-study")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "decisions_page",
    "own_pages",
    "generated",
    "mathml",
    "short_names",
]
exclude_patterns = ["ext", "**/.ipynb_checkpoints"]
templates_path: list[str] = []
nitpicky = True

# Markdown
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "strikethrough"]
myst_heading_anchors = 3
suppress_warnings = [
    "myst.strikethrough",  # decisions that were undone are struck out; the site is HTML only
]

# Notebooks are stored without outputs and run at every build; an error in a cell ends the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
nb_output_stderr = "remove"  # warnings of libraries, with the builder's folders in them

# Python
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
myst_dmath_allow_space = True
default_role = "code"  # docstrings mark code with one backtick
napoleon_custom_sections = [("Class attributes", "params_style")]

# HTML: nothing is asked of another host, neither fonts nor scripts nor formulas
html_theme = "furo"
html_title = "dubins-study"
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_show_sphinx = False
html_show_search_summary = False  # browsers do not let a page from a file read other files
copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True
