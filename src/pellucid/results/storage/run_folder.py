"""The folder of a run: where everything lies, how it is begun, and its summary."""

import hashlib
import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np

from pellucid.errors import UsageError
from pellucid.results.metrics import Metric, finite
from pellucid.results.storage import lock
from pellucid.results.storage.files import DRAFT, explained, replacing, usable, write_text

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.results.storage.stored_case import StoredCase


SIGNATURE = "# written by pellucid, as SHA-256 "
"""How the first line of a run's case begins; the digest is that of the lines below."""


class RunFolder:
    """The files of a run in the folder `path`. Nothing is read or written until a method is called."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.mark = self.path / lock.NAME
        self.case = self.path / "case.toml"
        self.history = self.path / "history.csv"
        self.summary = self.path / "summary.json"
        self.checkpoint = self.path / "checkpoint"
        self.figures = self.path / "figures"
        self.report = self.path / "report.html"
        self.forensics = self.path / "forensics"
        self._failure = self.forensics / "failure.json"
        self._state = self.forensics / "state.npz"

    def fields(self, body: str) -> Path:
        """The file of a body's frames."""
        return self.path / "fields" / f"{body}.vtkhdf"

    def check_replaceable(self) -> None:
        """Raise `UsageError` where a new run may not be written: a file, a folder with other files, one that is in use."""
        with usable(self.path):
            if self.path.exists() and not self.path.is_dir():
                raise UsageError(f"{self.path} is a file; give a folder for the results")
            if self.path.is_dir() and not self.mark.is_file() and any(self.path.iterdir()):
                text = f"{self.path} has other files in it than those of a run (it has no {lock.NAME})"
                raise UsageError(f"{text}; give a new or empty folder for the results")
            if self.case.is_file() and not _is_signed(self.case.read_bytes()):
                text = f"{self.case} was changed since its run began"
                raise UsageError(f"{text}; move it elsewhere, or give another folder for the results")
        lock.refuse_held(self.path)

    @contextmanager
    def made(self) -> Iterator[None]:
        """Make the folder for a new run, and keep others from writing into it. The mark is the first file in it."""
        self.check_replaceable()
        with explained(self.path), usable(self.path):
            self.path.mkdir(parents=True, exist_ok=True)
        with lock.held(self.path):
            yield

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep others from writing into the folder of a run. Raises `UsageError` where there is no run, or one that goes on."""
        if not self.mark.is_file():
            missing = "case.toml" if not self.case.is_file() else f"{lock.NAME}, the first file that a run writes"
            raise UsageError(f"there is no run in {self.path}: it has no {missing}")
        with lock.held(self.path):
            yield

    def start(self, case: "Case") -> None:
        """Begin a new run of `case` in a folder that is held; the results of an earlier run in it are removed.

        Raises `UsageError` for a folder that cannot be written to, `OutputError` for a full disk.
        """
        with explained(self.path), usable(self.path):
            shutil.rmtree(self.checkpoint, ignore_errors=True)  # first: nothing must resume from the earlier run
            self.history.unlink(missing_ok=True)
            _remove(self.path / "fields", (".vtkhdf",))
            self.reopen()
            if not self.case.is_file() or _is_signed(self.case.read_bytes()):  # one changed by hand is that of `case`
                self.write_case(case)

    def write_case(self, case: "Case") -> None:
        """Write the resolved case."""
        from pellucid.case import dumps

        with explained(self.path), usable(self.path):
            write_text(self.case, _signed(dumps(case)))

    def reopen(self) -> None:
        """Remove what only a finished or a failed run leaves: it is written again when the run ends."""
        with explained(self.path), usable(self.path):
            self.summary.unlink(missing_ok=True)
            self.report.unlink(missing_ok=True)
            _remove(self.figures, (".png", ".gif"))
            _remove(self.forensics, (".json", ".npz"))

    def read_case(self) -> "Case":
        """The resolved case. Raises `UsageError` where the folder holds no run."""
        from pellucid.case import load

        if not self.case.is_file():
            raise UsageError(f"there is no run in {self.path}: it has no case.toml")
        return load(self.case)

    def read_stored(self) -> "StoredCase":
        """The case without the kinds that it names, which results do not need. Raises `UsageError` where there is no run."""
        from pellucid.results.storage import stored_case

        try:
            return stored_case.read(self.case)
        except (OSError, KeyError, TypeError, ValueError):
            self.read_case()  # says what is wrong
            raise

    def write_summary(self, facts: Mapping[str, Any], metrics: Mapping[str, Metric]) -> None:
        """Write `summary.json`: the facts of the run as they are, and its metrics."""
        data = _json_safe(facts) | {"metrics": {name: metric.to_data() for name, metric in metrics.items()}}
        with explained(self.path):
            write_text(self.summary, json.dumps(data, indent=2, allow_nan=False) + "\n")

    @property
    def ended(self) -> bool:
        """Whether a run here reached its end, or the time given by `until`."""
        return self.summary.is_file()

    def read_summary(self) -> dict[str, Any]:
        """The summary. Raises `UsageError` where the run has not ended."""
        if not self.path.is_dir():
            raise UsageError(f"there is no folder {self.path}")
        if not self.ended:
            raise UsageError(f"the run in {self.path} has not ended; `pellucid resume {self.path}` goes on with it")
        return dict(json.loads(self.summary.read_text(encoding="utf-8")))

    def write_failure(self, failure: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        """Leave why a run stopped itself, and its whole state. Raises OSError where this cannot be written."""
        self.forensics.mkdir(exist_ok=True)
        write_text(self._failure, json.dumps(_json_safe(failure), indent=2, default=str, allow_nan=False) + "\n")
        with replacing(self._state) as temporary, temporary.open("wb") as file:
            np.savez(file, **dict(arrays))  # type: ignore[arg-type]

    def read_failure(self) -> dict[str, Any]:
        """Why the run stopped itself; empty where it did not."""
        if not self._failure.is_file():
            return {}
        try:
            return dict(json.loads(self._failure.read_text(encoding="utf-8")))
        except ValueError:
            return {"message": f"{self._failure} is damaged: why the run stopped is not known", "step": None, "time": None}

    def read_state(self) -> dict[str, np.ndarray]:
        """The state in which a run stopped itself, arrays as `<body>/<name>`; empty where there is none."""
        try:
            with np.load(self._state, allow_pickle=False) as arrays:
                return dict(arrays)
        except (OSError, ValueError, EOFError, BadZipFile):  # none, or one that is damaged
            return {}


def _remove(folder: Path, endings: tuple[str, ...]) -> None:
    """Remove files of these endings from a folder, and it where nothing else is in it."""
    for path in folder.glob("*"):
        if path.suffix in (*endings, DRAFT):
            path.unlink(missing_ok=True)
    with suppress(OSError):
        folder.rmdir()


def _signed(text: str) -> str:
    return f"{SIGNATURE}{hashlib.sha256(text.encode()).hexdigest()}\n{text}"


def _is_signed(data: bytes) -> bool:
    """Whether a case is still as a run wrote it."""
    return data == _signed(data.partition(b"\n")[2].decode(errors="replace")).encode()


def _json_safe(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _json_safe(item) for name, item in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_json_safe(item) for item in value]
    return finite(value) if isinstance(value, float) else value
