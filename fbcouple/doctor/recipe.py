"""Recipes of containers, Spack and modules, from the list of what fbcouple needs that scripts/install.sh reads, too."""

from __future__ import annotations

import sys
from pathlib import Path

from fbcouple.decks.render import make_environment
from fbcouple.version import __version__

PACKAGES = Path(__file__).with_name("system_packages.txt")
"""The list: what for, Debian's package, Spack's."""
RECIPES = ("apptainer", "docker", "spack", "modules")
"""What a recipe may be for; each is a template in templates/recipes/."""
NEEDED = ("python", "run", "build", "views")
"""What a recipe brings; packages that only tests need are left out."""


def read_packages(wanted: tuple[str, ...] = NEEDED) -> list[tuple[str, str]]:
    """Debian's and Spack's name of every package for one of `wanted`, in the order of the list; "-": Spack has none."""
    rows = [line.split() for line in PACKAGES.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return [(debian, spack) for use, debian, spack in rows if use in wanted]


def write_recipe(name: str) -> str:
    """The text of the recipe `name`, one of RECIPES."""
    packages = read_packages()
    context = {
        "debian": [debian for debian, _ in packages],
        "spack": [spack for _, spack in packages if spack != "-"],
        "wheel": f"fbcouple-{__version__}-py3-none-any.whl",
        "python": ".".join(map(str, sys.version_info[:2])),
    }
    return make_environment().get_template(f"recipes/{name}").render(context)
