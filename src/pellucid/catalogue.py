"""The catalogue of the gallery: ids of the cases, their files and their modules.

This module imports no other module of the package: the modules in `gallery/` import the results, and reading a case only
needs the path of its file.
"""

import difflib
import re
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import ModuleType, SimpleNamespace

GALLERY = "pellucid.gallery"


@cache
def ids() -> tuple[str, ...]:
    """Return the ids of all cases of the gallery (the cases that the package contains), such as "gan2011/shock-tube",
    sorted."""
    groups = (group for group in files(GALLERY).iterdir() if group.is_dir())
    found = (f"{group.name}/{item.name[:-5]}" for group in groups for item in group.iterdir() if item.name.endswith(".toml"))
    return tuple(sorted(found))


def has(case: str) -> bool:
    """Return True if the gallery (the cases that the package contains) has a case with this id."""
    return case in ids()


def text(case: str) -> str:
    """Return the text of the file of a gallery case, by its id."""
    group, name = case.split("/")
    return (files(GALLERY) / group / f"{name}.toml").read_text(encoding="utf-8")


def to_copy(case: str) -> str:
    """Return the text of the file of a gallery case, by its id, with absolute paths of its input files, so that a copy
    works in any folder."""
    home = Path(folder(case))

    def whole(found: re.Match[str]) -> str:
        file = (home / found[2]).resolve()
        return f'{found[1]}{file}"' if file.is_file() else found[0]

    return re.sub(r'(\b(?:path"? = |extensions = \[)")([^"]+)"', whole, text(case))


def folder(case: str) -> str:
    """Return the folder that contains the file of a gallery case, given by its id, and its input files."""
    return str(files(GALLERY) / case.split("/")[0])


def module(case: str) -> ModuleType | SimpleNamespace | None:
    """Return the `metrics` and `figures` of a gallery case, given by its id: its Python module, or its entry in `CASES` of a
    module of several cases; None if the case has none.

    `METRICS` of the result lists the names of all metrics that the case can have, known before a run.
    """
    from importlib import import_module
    from importlib.util import find_spec

    shared = import_module(GALLERY).MODULES.get(case)
    name = f"{GALLERY}.{shared or case.replace('/', '.').replace('-', '_')}"
    if not (has(case) and find_spec(name)):
        return None
    found = import_module(name)
    return getattr(found, "CASES", {}).get(case.split("/")[1], found)


def suggestion(name: str) -> str:
    """Return the remedy for an unknown name of a case: a similar gallery id, or how to list the ids."""
    close = difflib.get_close_matches(name, ids(), 1, cutoff=0.5)
    return (
        f"did you mean `{close[0]}`?"
        if close
        else "Run `pellucid list` to list the gallery ids; the name of a case file must end in .toml."
    )
