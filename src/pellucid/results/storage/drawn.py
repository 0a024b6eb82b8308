"""List of the pictures that the program drew in the figures folder of a run, so that pictures of the user are never
removed.

The list is a file in this folder. The name of a picture is added before the picture is written.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pellucid.results.storage.files import DRAFT, draft_of, replacing, write_text

LIST = ".drawn"


@contextmanager
def drawing(path: Path) -> Iterator[Path]:
    """Yield a temporary path for a picture. If the block succeeds, add its name to the list of drawn pictures, then move it to
    `path`."""
    with replacing(path) as temporary:
        yield temporary
        if path.name not in (known := _names(path.parent)):
            write_text(path.parent / LIST, "".join(f"{name}\n" for name in [*known, path.name]))


def files(folder: Path) -> list[Path]:
    """Return the paths of the pictures drawn by `drawing`, their drafts and their list."""
    pictures = [path for name in _names(folder) for path in (draft_of(folder / name), folder / name)]
    drafts = [path for path in folder.glob(f".*{DRAFT}") if path.with_suffix("").suffix in (".png", ".gif")]
    return [*pictures, *drafts, draft_of(folder / LIST), folder / LIST]


def _names(folder: Path) -> list[str]:
    try:
        return [name for name in (folder / LIST).read_text(encoding="utf-8").split("\n") if name == Path(name).name != ""]
    except (OSError, ValueError):
        return []
