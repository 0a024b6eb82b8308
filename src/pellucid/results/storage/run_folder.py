"""The folder of a run: where everything lies, how it is begun, and its summary."""

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pellucid.errors import UsageError
from pellucid.results.metrics import Metric, finite
from pellucid.results.storage.files import explained, is_draft, usable, write_text

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.results.storage.stored_case import StoredCase


class RunFolder:
    """The files of a run in the folder `path`. Nothing is read or written until a method is called."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.case = self.path / "case.toml"
        self.history = self.path / "history.csv"
        self.summary = self.path / "summary.json"
        self.checkpoint = self.path / "checkpoint"
        self.figures = self.path / "figures"
        self.report = self.path / "report.html"
        self.forensics = self.path / "forensics"

    def fields(self, body: str) -> Path:
        """The file of a body's frames."""
        return self.path / "fields" / f"{body}.vtkhdf"

    def start(self, case: "Case") -> None:
        """Make the folder ready for a new run of `case`; the results of an earlier run in it are removed.

        Raises `UsageError` for a folder with other files in it or that cannot be written to, `OutputError` for a full disk.
        """
        from pellucid.case import dumps

        with explained(self.path), usable(self.path):
            if self.path.exists() and not self.path.is_dir():
                raise UsageError(f"{self.path} is a file; give a folder for the results")
            if self.path.is_dir() and not self.case.is_file() and not all(map(is_draft, self.path.iterdir())):
                raise UsageError(
                    f"{self.path} has other files in it than those of a run; give a new or empty folder for the results"
                )
            self.path.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(self.checkpoint, ignore_errors=True)  # first: nothing must resume from the earlier run
            self.history.unlink(missing_ok=True)
            shutil.rmtree(self.path / "fields", ignore_errors=True)
            self.reopen()
            write_text(self.case, dumps(case))

    def reopen(self) -> None:
        """Remove what only a finished or a failed run leaves: it is written again when the run ends."""
        with explained(self.path), usable(self.path):
            self.summary.unlink(missing_ok=True)
            self.report.unlink(missing_ok=True)
            shutil.rmtree(self.figures, ignore_errors=True)
            shutil.rmtree(self.forensics, ignore_errors=True)

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


def _json_safe(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _json_safe(item) for name, item in value.items()}
    return finite(value) if isinstance(value, float) else value
