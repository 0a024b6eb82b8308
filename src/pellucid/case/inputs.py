"""Files that a case depends on in addition to the case file: tables of motions, surfaces, extensions, files that register
kinds."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from pellucid.case.probe import OWN_REDUCTIONS, QUANTITIES, REDUCTIONS
from pellucid.case.spec import Case
from pellucid.users.users_code import file_of, is_own


def digests(case: Case) -> dict[str, str]:
    """Return the SHA-256 digest of every input file of a case, by path. A run can be resumed only with unchanged input
    files.

    The folder of an earlier run is not included, since its state is needed only at the start. Measured curves are not
    included either, since they do not affect the run.
    """
    data = {key: value for key, value in case.to_data().items() if key not in ("plot", "check")}
    paths = sorted(path for path in {*case.extensions, *_paths(data)} if not Path(path).is_dir())
    return {path: hashlib.sha256(Path(path).read_bytes()).hexdigest() for path in paths}


def users_kinds(case: Case) -> dict[str, str]:
    """Return the path of the file that registered each user-defined kind, reduction and quantity that a case uses, by the
    name of the kind, reduction or quantity."""
    found = {}
    for probe in case.probe:
        if probe.reduce not in OWN_REDUCTIONS:
            found[probe.reduce] = file_of(REDUCTIONS.entries[probe.reduce])
        if probe.quantity in QUANTITIES.entries:
            found[probe.quantity] = file_of(QUANTITIES.entries[probe.quantity].function)
    found |= {str(part.kind): file_of(type(part)) for part in _tables(case) if hasattr(part, "kind")}
    return {name: file for name, file in found.items() if not is_own(file)}


def _tables(value: Any) -> Iterator[Any]:
    if isinstance(value, BaseModel):
        yield value
        value = [getattr(value, name) for name in type(value).model_fields]
    for item in value if isinstance(value, (list, tuple)) else ():
        yield from _tables(item)


def _paths(data: Any) -> Iterator[str]:
    if isinstance(data, dict):
        for key, value in data.items():
            if key == "path" and isinstance(value, str):
                yield value
            yield from _paths(value)
    elif isinstance(data, list):
        for item in data:
            yield from _paths(item)
