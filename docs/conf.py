"""Configuration of the documentation: `python -m sphinx -W -b html docs docs/_build`.

Pages of the reference hold lines `<!-- generated: NAME -->`, which are replaced by what `_ext/generated.py` reads from
the code. Formulas become MathML, so that the pages need no script and no network.
"""

import sys
from pathlib import Path

import mpi4py

HERE = Path(__file__).resolve().parent
mpi4py.rc.initialize = False  # checks import MPI, and no page runs them
sys.path[:0] = [str(HERE.parent), str(HERE / "_ext")]

from fbcouple import __version__  # noqa: E402

project = "fbcouple"
author = "the fbcouple maintainers"
copyright = "the fbcouple maintainers, GPL-3.0-or-later"
version = release = __version__

extensions = ["myst_parser", "generated", "mathml"]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"fbcouple {release}"
html_copy_source = False
smartquotes = False
html_show_sphinx = False
pygments_style = "friendly"
