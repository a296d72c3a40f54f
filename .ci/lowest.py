"""Print pip constraints that pin each dependency of pyproject.toml with a lower bound to that bound."""

import re
import tomllib
from pathlib import Path

LOWER_BOUND = re.compile(r"(?P<name>[\w-]+)>=(?P<version>[\d.]+)")

project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
for requirements in (project["dependencies"], *project["optional-dependencies"].values()):
    for requirement in requirements:
        if found := LOWER_BOUND.match(requirement):
            print("{name}=={version}".format(**found.groupdict()))
