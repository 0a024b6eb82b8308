"""The folder of a run: paths of its files, creation, summary, and the part of its case that results need."""

import hashlib
import json
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from pydantic import BaseModel, ConfigDict

from pellucid.case import Case, EnergyCase, OutputCase, TimeCase, dumps, load
from pellucid.case.judgement import Check
from pellucid.case.picture import Film, Picture
from pellucid.case.plot import Plot
from pellucid.case.steady import SteadyCase
from pellucid.errors import UsageError
from pellucid.findings import Named
from pellucid.grid.model import GridCase
from pellucid.results.metrics import Metric, finite, mean_columns
from pellucid.results.storage import checkpoint
from pellucid.results.storage.files import (
    LOCK,
    OutputError,
    draft_of,
    drawn_files,
    explained,
    is_own_lock,
    is_signed_lock,
    lock_held,
    refuse_locked,
    replacing,
    usable,
    write_text,
)

SIGNATURE = "# written by pellucid, as SHA-256 "
"""Start of the first line of a run's case file, followed by the SHA-256 digest of the lines below it."""


class StoredBody(NamedTuple):
    """Data of a body that readers of results need: its name, kind, kinds of material and equation of state (empty if none),
    and density [kg/m³], or the surface density [kg/m²] of a fluid film."""

    name: str
    kind: str
    material: str
    equation_of_state: str
    density: float
    thickness: float | None = None
    """Thickness of a membrane [m]."""
    contact_offset: float | None = None
    """Distance from the mid-surface of a membrane at which other bodies are in contact with it [m]."""


class StoredWall(NamedTuple):
    """A plane wall of the case, for pictures: its name, a point on the plane at time 0 [m], the unit normal towards the
    bodies, and the velocity of the plane [m/s], each vector of shape (3,)."""

    name: str
    point: np.ndarray
    normal: np.ndarray
    velocity: np.ndarray

    def level(self, time: float) -> float:
        """Return the signed distance of the plane from the origin along its normal [m] at a time [s]."""
        return float(self.normal @ (self.point + time * self.velocity))


SHOWN = ("body", "probe", "picture", "film", "plot", "check", "extensions")
"""Lists of a case that the report shows separately."""


class StoredCase(BaseModel):
    """The part of a case that readers of results need. Kinds (of bodies and materials) are stored as texts, because users
    may define kinds that are not available when results are read."""

    model_config = ConfigDict(arbitrary_types_allowed=True)

    title: str
    id: str = ""
    source: str = ""
    description: str = ""
    extensions: tuple[str, ...] = ()
    grid: GridCase | None = None
    time: TimeCase
    steady: SteadyCase | None = None
    output: OutputCase = OutputCase()
    energy: EnergyCase = EnergyCase()
    bodies: tuple[StoredBody, ...]
    probes: tuple[str, ...]
    """Names of the probes."""
    means: tuple[str, ...] = ()
    """Names of the probes whose values are means since the previous row, see `pellucid.results.metrics`."""
    walls: tuple[StoredWall, ...] = ()
    others: dict[str, int] = {}
    """Number of entries of the other tables, such as supports, by key."""
    picture: tuple[Picture, ...] = ()
    film: tuple[Film, ...] = ()
    plot: tuple[Plot, ...] = ()
    check: tuple[Check, ...] = ()

    @property
    def thin(self) -> tuple[bool, bool, bool]:
        """Mask of the axes along which the grid is one cell thick; all False without a grid."""
        return (False, False, False) if self.grid is None else self.grid.thin()


def read_stored_case(path: Path) -> StoredCase:
    """Read the case file of a run. Raises KeyError or ValueError for another file."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    bodies = [_stored_body(table) for table in data["body"]]
    lists = {key: tables for key, tables in data.items() if isinstance(tables, list) and key not in SHOWN and tables}
    others = {key: len(tables) for key, tables in lists.items() if isinstance(tables[0], dict)}
    quantities = {probe["name"]: str(probe.get("quantity", "")) for probe in data.get("probe", ())}
    own = {"bodies": bodies, "probes": list(quantities), "others": others}
    own["walls"] = [_stored_wall(table, number) for number, table in enumerate(data.get("wall", ()))]
    own["means"] = mean_columns(quantities.items(), "steady" in data)
    return StoredCase.model_validate({**data, **own})


def _stored_body(table: dict[str, Any]) -> StoredBody:
    material = table["material"]
    law = material["eos"]["kind"] if "eos" in material else ""
    thickness = table.get("thickness")
    offset = table.get("contact_offset", None if thickness is None else 0.5 * thickness)
    return StoredBody(table["name"], table["kind"], material["kind"], law, material["density"], thickness, offset)


def _stored_wall(table: dict[str, Any], number: int) -> StoredWall:
    normal = np.array(table["normal"], float)
    normal /= np.abs(normal).max()  # so that no square of a component overflows or vanishes
    velocity = np.array(table.get("velocity", (0.0, 0.0, 0.0)), float)
    name = f"wall {table.get('name', number + 1)}"
    return StoredWall(name, np.array(table["point"], float), normal / np.linalg.norm(normal), velocity)


class RunFolder:
    """Folder of a run: paths of its files, and methods that create, read and write them. Nothing is read or written until a
    method is called."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.mark = self.path / LOCK
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
        """Return the path of the file with the fields of a body at all frames."""
        return self.path / "fields" / f"{body}.vtkhdf"

    def check_replaceable(self) -> None:
        """Raise `UsageError` if a new run must not be written to this path: the path is a file, or the folder contains
        other files or is in use by another process."""
        with usable(self.path):
            if self.path.exists() and not self.path.is_dir():
                raise UsageError(f"{self.path} is a file.\n    Choose a folder for the results.")
            if self.path.is_dir() and not self.is_of_a_run and any(self.path.iterdir()):
                text = f"{self.path} contains files that do not belong to a run ({self._lacking()})"
                raise UsageError(f"{text}.\n    Choose a new or empty folder for the results.")
            if self.case.is_file() and not _is_signed(self.case.read_bytes()):
                text = f"{self.case} has changed since its run started"
                raise UsageError(f"{text}.\n    Move it to another folder, or choose another folder for the results.")
        refuse_locked(self.path)

    @property
    def is_of_a_run(self) -> bool:
        """True if a run was started in this folder, judged by the contents of its first files. File names alone are not
        sufficient, because other programs use the same names."""
        if is_signed_lock(self.mark):
            return True
        if not self.mark.is_file():
            return False
        if self.case.is_file():  # a run that was killed, or had no room, before it could sign its lock
            return self.case.read_bytes().startswith(SIGNATURE.encode())
        return not self.mark.stat().st_size and self._has_nothing_yet

    @property
    def _has_nothing_yet(self) -> bool:
        """True if the folder contains only the lock file and the draft of the case."""
        return set(self.path.iterdir()) <= {self.mark, draft_of(self.case)}

    @property
    def was_held_here(self) -> bool:
        """True if this process was the last owner of the lock of the folder."""
        return is_own_lock(self.mark)

    def _lacking(self) -> str:
        return f"its {LOCK} was not written by pellucid" if self.mark.is_file() else f"it has no {LOCK}"

    @contextmanager
    def made(self) -> Iterator[None]:
        """Create the folder of a new run and hold its lock during the block, since only one process may write to a run. The
        lock file is the first file in the folder."""
        self.check_replaceable()
        with explained(self.path), usable(self.path):
            self.path.mkdir(parents=True, exist_ok=True)
        with lock_held(self.path):
            yield

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the lock of the folder during the block. Raises `UsageError` if the folder contains no run or is in use."""
        if not self.is_of_a_run:
            missing = self._without_case() if not self.case.is_file() else f"{self._lacking()}, the first file of a run"
            raise UsageError(f"{self.path} contains no run: {missing}")
        with lock_held(self.path):
            yield

    def start(self, case: Case) -> None:
        """Start a new run of `case` in this folder, whose lock is held; remove the results of an earlier run in the folder.

        Raises `UsageError` if the folder cannot be written to, `OutputError` on a full disk.
        """
        with explained(self.path), usable(self.path):
            _remove(checkpoint.files(self.checkpoint), self.checkpoint)  # first: nothing must resume from the earlier run
            self.discard_record(case)
            if not self.case.is_file() or _is_signed(self.case.read_bytes()):  # one changed by hand is that of `case`
                self.write_case(case)

    def discard_record(self, case: Case) -> None:
        """Remove all results except checkpoints: results of an earlier run, or of a start whose settling failed."""
        with explained(self.path), usable(self.path):
            bodies = {*self._stored_bodies(), *(body.name for body in case.body)}
            _remove(_with_drafts([self.history]))
            _remove(_with_drafts(map(self.fields, bodies)), self.path / "fields")
            self.reopen()

    def _stored_bodies(self) -> list[str]:
        """Return the names of the bodies of an earlier run in this folder; empty if the folder contains no earlier run."""
        try:
            return [body.name for body in read_stored_case(self.case).bodies]
        except (OSError, KeyError, TypeError, ValueError):
            return []

    def write_case(self, case: Case) -> None:
        """Write the resolved case (with defaults filled in) to `case.toml`."""
        with explained(self.path), usable(self.path):
            write_text(self.case, _signed(dumps(case)))

    def reopen(self) -> None:
        """Remove the files that only a finished or failed run has, such as the summary. The resumed run writes these files
        again when it ends."""
        with explained(self.path), usable(self.path):
            _remove(_with_drafts([self.summary, self.report]))
            _remove(drawn_files(self.figures), self.figures)
            _remove(_with_drafts([self._failure, self._state]), self.forensics)

    def read_case(self, settings: Mapping[str, Any] | None = None) -> Case:
        """Read the resolved case, with `settings` (values by dotted key) applied as in `load`. Raises `UsageError` if the
        folder contains no run."""
        if not self.case.is_file():
            raise UsageError(f"{self.path} contains no run: {self._without_case()}")
        return load(self.case, settings)

    def _without_case(self) -> str:
        if self.is_of_a_run and self._has_nothing_yet:
            text = "a run that was started in this folder ended before it wrote anything"
            return f"{text}\n    Run it again: `pellucid run CASE --out {self.path}`."
        if self.path.is_dir():
            return "it has no case.toml"
        return "it is not a folder" if self.path.exists() else "the folder does not exist"

    def read_stored(self) -> StoredCase:
        """Read the part of the case that readers of results need. The kinds of bodies and materials in the case need not be
        registered. Raises `UsageError` if the folder contains no run."""
        try:
            return read_stored_case(self.case)
        except (OSError, KeyError, TypeError, ValueError):
            self.read_case()  # says what is wrong
            raise

    def write_summary(self, facts: Mapping[str, Any], metrics: Mapping[str, Metric]) -> None:
        """Write `summary.json` with the values `facts` of the run (see `Recorder.facts`) and the metrics of the run by
        name."""
        data = _json_safe(facts) | {"metrics": {name: metric.to_data() for name, metric in metrics.items()}}
        with explained(self.path):
            write_text(self.summary, json.dumps(data, indent=2, allow_nan=False) + "\n")

    @property
    def ended(self) -> bool:
        """True if the run in this folder reached the end of its case or the time given by `until`."""
        return self.summary.is_file()

    def read_summary(self) -> dict[str, Any]:
        """Return the contents of `summary.json`. Raises `UsageError` if the run has not ended."""
        if not self.path.is_dir():
            raise UsageError(f"The folder {self.path} does not exist.")
        if not self.ended:
            raise UsageError(f"The run in {self.path} is not finished.\n    Run `pellucid resume {self.path}` to continue it.")
        found = None
        with suppress(ValueError):
            found = json.loads(
                self.summary.read_text(encoding="utf-8"), object_hook=partial(Named, f"{self.summary} has no entry")
            )
        if not isinstance(found, dict):
            text = f"{self.summary} is damaged\n    Remove it and run `pellucid resume {self.path}`, which writes it again."
            raise OutputError(text)
        return found

    def write_failure(self, failure: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        """Write the reason of an error stop (`failure`, the data that `Run.stopped` returns) and the whole state at the
        stop (`arrays`, by `<body>/<name>`). Raises OSError if the files cannot be written."""
        self.forensics.mkdir(exist_ok=True)
        write_text(self._failure, json.dumps(_json_safe(failure), indent=2, default=str, allow_nan=False) + "\n")
        with replacing(self._state) as temporary, temporary.open("wb") as file:
            np.savez(file, **dict(arrays))  # type: ignore[arg-type]

    def read_failure(self) -> dict[str, Any]:
        """Read the data of an error stop, as `Run.stopped` returns them; empty if the run did not stop with an error."""
        if not self._failure.is_file():
            return {}
        try:
            return dict(json.loads(self._failure.read_text(encoding="utf-8")))
        except ValueError:
            return {
                "message": f"The run stopped with an error, but {self._failure} is damaged, so the reason is unknown.",
                "step": None,
                "time": None,
            }

    def read_state(self) -> dict[str, np.ndarray]:
        """Read the state at an error stop: arrays by `<body>/<name>`; empty if no state is stored or if the file is
        damaged."""
        try:
            with np.load(self._state, allow_pickle=False) as arrays:
                return dict(arrays)
        except (OSError, ValueError, EOFError, BadZipFile):  # none, or one that is damaged
            return {}


def _remove(files: Iterable[Path], folder: Path | None = None) -> None:
    """Remove files written by the program, and then `folder` if it is empty."""
    for path in files:
        path.unlink(missing_ok=True)
    if folder is not None:
        with suppress(OSError):
            folder.rmdir()


def _with_drafts(files: Iterable[Path]) -> list[Path]:
    return [path for file in files for path in (draft_of(file), file)]


def _signed(text: str) -> str:
    return f"{SIGNATURE}{hashlib.sha256(text.encode()).hexdigest()}\n{text}"


def _is_signed(data: bytes) -> bool:
    """Return True if `data` (contents of a case file) carry the signature of a run and are unchanged since then."""
    return data == _signed(data.partition(b"\n")[2].decode(errors="replace")).encode()


def _json_safe(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _json_safe(item) for name, item in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_json_safe(item) for item in value]
    return finite(value) if isinstance(value, float) else value
