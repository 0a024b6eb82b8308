"""Files of meshes: read through meshlane, and known again while they do not change."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pellucid.model import Model

FileState = tuple[str, int, int]
"""Path, time of the last change [ns], length [bytes]."""


def read_mesh(path: str, what: str) -> Any:
    """The mesh in a file, as meshlane gives it. Raises ValueError where it cannot be read as `what`, with its article."""
    if not Path(path).is_file():
        raise ValueError(f"there is no file {path}")
    if find_spec("meshlane") is None:
        raise ValueError(f"reading {path} needs meshlane: pip install 'pellucid[mesh]'")
    import meshlane

    try:
        return meshlane.read(path)
    except (Exception, SystemExit) as error:  # its readers raise whatever their parsing meets
        reason = str(error).strip() or type(error).__name__
        raise ValueError(f"{path} cannot be read as {what}: {reason}") from None


def states_of_files(model: Model) -> tuple[FileState, ...]:
    """The states of all files that a model and the models in it name under the key `path`. Raises ValueError for a missing
    file."""
    states: list[FileState] = []
    for name, value in model:
        if isinstance(value, Model):
            states += states_of_files(value)
        elif name == "path":
            if not Path(value).is_file():
                raise ValueError(f"there is no file {value}")
            found = Path(value).stat()
            states.append((value, found.st_mtime_ns, found.st_size))
    return tuple(states)
