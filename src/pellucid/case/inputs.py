"""The files that a case reads beside its own: tables of motions, surfaces, extensions."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pellucid.case.spec import Case


def digests(case: Case) -> dict[str, str]:
    """SHA-256 of every input file, by its path: a run goes on only with the files that it began with."""
    paths = sorted({*case.extensions, *_paths(case.to_data())})
    return {path: hashlib.sha256(Path(path).read_bytes()).hexdigest() for path in paths}


def _paths(data: Any) -> Iterator[str]:
    if isinstance(data, dict):
        for key, value in data.items():
            if key == "path" and isinstance(value, str):
                yield value
            yield from _paths(value)
    elif isinstance(data, list):
        for item in data:
            yield from _paths(item)
