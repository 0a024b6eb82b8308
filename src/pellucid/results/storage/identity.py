"""Identity of a run: data by which a run is recognized when it is resumed. A checkpoint is resumed only with the case, its
input files, the bodies and the version that wrote it. Version and git commit of the package."""

import hashlib
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import BaseModel

from pellucid.case.probe import OWN_REDUCTIONS, QUANTITIES, REDUCTIONS
from pellucid.case.spec import Case
from pellucid.errors import UsageError, shown
from pellucid.users.users_code import file_of, is_own

if TYPE_CHECKING:
    from pellucid.case import Case


Start = Mapping[str, Mapping[str, np.ndarray]]
"""Arrays of the bodies that continue from an earlier run, by name; empty if the case does not continue a run."""
TEXTS = ("title", "source", "description", "times", "quick", "picture", "film", "plot", "check")
"""Keys of a case that have no effect on the simulation."""
MAY_CHANGE = (
    *TEXTS,
    "output",
    *("time.end", "time.step", "time.courant", "settle.most_steps", "energy.warn", "energy.stop"),
    *("steady.most_steps", "steady.tolerance"),
)
"""Keys of a case that may change when a run is resumed."""
MOST_SHOWN = 5


def identity(case: "Case", bodies: Sequence[Any], start: str) -> dict[str, Any]:
    """Return the identity that a checkpoint stores, for JSON: version, case, numbers of points of the bodies, and the digest of
    the initial state. start: result of `start_digest`."""
    points = {body.name: body.n_points for body in bodies}
    return {"version": package_release(), "case": _fixed(case), "points": points, "start": start}


def check_case(folder: Path, case: "Case", kept: Mapping[str, Any]) -> None:
    """Raise `UsageError`, with the differences, if the run in `folder` was started with another case or another version of
    the package; kept: the `identity` stored in the checkpoint of the run."""
    if not kept:
        _refuse(folder, ["the checkpoint was written by an earlier version of pellucid"])
    if kept["version"] != package_release():
        _refuse(folder, [f"the run was started with pellucid {kept['version']}, but this is version {package_release()}"])
    _refuse(folder, _differences(kept["case"], _fixed(case)), "Restore the old values to continue, or start a new run.")


def with_changes(case: "Case", settings: Mapping[str, object]) -> "Case":
    """Return the case of a run with new settings (values by dotted key), with which the run continues.

    Raises `CaseError` for an invalid setting, and `UsageError` for a setting that may not change in a run (see
    `MAY_CHANGE`).
    """
    new = case.with_settings(settings)
    differences = _differences(_fixed(case), _fixed(new))
    if differences:
        text = "\n    ".join(["A run can only continue with the same bodies and conditions:", *differences[:MOST_SHOWN]])
        free = ", ".join(key for key in MAY_CHANGE if key not in TEXTS)
        raise UsageError(f"{text}\n    Only {free} may change. Start a new run for other changes.")
    return new


def with_pictures(case: "Case", other: "Case") -> "Case":
    """Return the case of a run with the pictures, films, plots and checks of another case, `other`. Raises `CaseError` if
    the run does not have the bodies or columns that these require."""
    data, new = case.to_data(), other.to_data()
    return type(case).model_validate({**data, **{key: new.get(key, ()) for key in ("picture", "film", "plot", "check")}})


def check_start(folder: Path, start: Start, kept: Mapping[str, Any]) -> None:
    """Raise `UsageError` if the initial state, which is read from an earlier run, has changed since the run in `folder` was
    started. (Regions of the case are evaluated in the initial state.) start: initial state as read now. kept: the
    `identity` stored in the checkpoint of the run."""
    if start_digest(start) != kept["start"]:
        _refuse(folder, ["the earlier run that provides the initial state (start.path) has changed"])


def check_bodies(folder: Path, bodies: Sequence[Any], kept: Mapping[str, Any]) -> None:
    """Raise `UsageError` if the numbers of points of the bodies differ from the numbers in a checkpoint of the run in
    `folder`; kept: the `identity` stored in this checkpoint."""
    before, now = kept["points"], {body.name: body.n_points for body in bodies}
    changed = [name for name in now if before.get(name) != now[name]]
    _refuse(folder, [f"body {name} had {before.get(name)} points and now has {now[name]}" for name in changed])


def _refuse(folder: Path, differences: Sequence[str], remedy: str = "Start a new run.") -> None:
    if differences:
        more = len(differences) - MOST_SHOWN
        lines = [f"The run in {folder} cannot continue, because its case has changed:", *differences[:MOST_SHOWN]]
        raise UsageError("\n    ".join([*lines, *([f"and {more} more differences"] if more > 0 else []), remedy]))


def _fixed(case: "Case") -> dict[str, Any]:
    data = case.to_data()
    for key in MAY_CHANGE:
        *way, last = key.split(".")
        table: Any = data
        for part in way:
            table = table.get(part, {})  # a case need not have every table
        table.pop(last, None)
    return data


def start_digest(start: Start) -> str:
    """Return the SHA-256 digest of the arrays with which the bodies continue an earlier run; empty if the case does not
    continue a run."""
    if not start:
        return ""
    found = hashlib.sha256()
    for body, arrays in sorted(start.items()):
        for name, array in sorted(arrays.items()):
            found.update(f"{body}/{name}".encode())
            found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def _differences(before: Any, now: Any, place: str = "") -> list[str]:
    """Compare a value of a case before and now, entry by entry for tables and lists; return a line of text for each
    difference, with the dotted key of the entry. place: dotted key of the value."""
    if isinstance(before, dict) and isinstance(now, dict):
        keys = dict.fromkeys([*before, *now])
        inner = [(key, before.get(key), now.get(key)) for key in keys]
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        inner = [(_name(new, number), old, new) for number, (old, new) in enumerate(zip(before, now, strict=True))]
    elif before == now:
        return []
    else:
        return [f"{place} was {told(before)} and is now {told(now)}"]
    return [text for name, old, new in inner for text in _differences(old, new, f"{place}.{name}".lstrip("."))]


def _name(item: Any, number: int) -> str:
    return str(item.get("name", number)) if isinstance(item, dict) else str(number)


def told(value: Any) -> str:
    """Return a value of a case as text for a message; None is "not set"."""
    return "not set" if value is None else shown(value)


SOURCE = Path(__file__).parents[2] / "__init__.py"


def package_version() -> str:
    """Return the version of the pellucid package."""
    return version("pellucid")


def package_release() -> str:
    """Return the release number without development suffixes. A run can be resumed with any development version of the same
    release."""
    return package_version().partition("+")[0].partition(".dev")[0]


def package_commit() -> str:
    """Return the git commit of the package's source; empty if the source is not a git checkout."""
    git = shutil.which("git")
    if git is None:
        return ""
    call = [git, "-C", str(SOURCE.parent)]
    # an environment inside someone's checkout is not a checkout of the package: git must know this very file
    tracked = subprocess.run([*call, "ls-files", "--error-unmatch", SOURCE.name], capture_output=True, check=False)
    if tracked.returncode:
        return ""
    head = subprocess.run([*call, "rev-parse", "HEAD"], capture_output=True, text=True, check=False)
    return head.stdout.strip()


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
