"""The members of a study, i.e. its single runs: cases identified by a digest of their contents, and their paths in the
study's folder."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid.errors import PellucidError, UsageError
from pellucid.results.storage.files import explained, usable, write_text
from pellucid.results.storage.run import Run
from pellucid.results.storage.run_folder import RunFolder
from pellucid.studies.ranges import all_checked

if TYPE_CHECKING:
    from pellucid.case import Case

TEXTS = ("title", "source", "description", "times", "quick")
"""Keys of a case that have no effect on its results."""
DONE, FAILED, INTERRUPTED = "done", "failed", "interrupted"


@dataclass(frozen=True)
class Member:
    """A member of a study, i.e. one of its runs: varied settings, the case with these settings, end time [s], and the
    digest that identifies the member."""

    settings: Mapping[str, Any]  # values of the varied keys, by dotted key
    case: "Case"  # case with these settings
    until: float | None  # time at which the run ends [s]; None: end of the case
    digest: str  # identifies the member, also as the name of its folder


class Outcome(NamedTuple):
    """Outcome of a member of a study: state ("done", "failed" or "interrupted"), and message for the user (empty if done)."""

    state: str  # "done", "failed" or "interrupted"
    message: str = ""  # text for the user; empty if done


class Places(NamedTuple):
    """Paths of the folder and files of a member in the folder of its study: folder of the run, case file, log file."""

    run: Path  # folder of the results
    case: Path  # case file
    log: Path  # output of the process that ran the member


def members_of(case: "Case", rows: Sequence[Mapping[str, Any]], until: float | None = None) -> list[Member]:
    """Return the members of a study, without duplicates: the case with each row of settings (values by dotted key).

    until: time at which the runs end [s]; default: end of the case. Raises CaseError with all problems of all members, and
    UsageError if `until` is after the end of a case.
    """
    from pellucid.running.launch import check_until

    found: dict[str, Member] = {}
    for row, own in zip(rows, all_checked(case, rows), strict=True):
        check_until(until, own)
        digest = _digest(own, until)
        found.setdefault(digest, Member(row, own, until, digest))
    return list(found.values())


def _digest(case: "Case", until: float | None) -> str:
    """Return twelve digits of the SHA-256 digest of the case, without its texts, of the files that it reads and of the end time
    `until` of the run [s]."""
    from pellucid.results.storage.identity import digests

    data = {key: value for key, value in case.to_data().items() if key not in TEXTS}
    whole = json.dumps([data, until, digests(case)], sort_keys=True)
    return hashlib.sha256(whole.encode()).hexdigest()[:12]


def places(out: Path, digest: str) -> Places:
    """Return the paths of the member with a digest in the folder `out` of a study: its run in `members/`, its case, and its
    log."""
    return Places(out / "members" / digest, out / "cases" / f"{digest}.toml", out / "logs" / f"{digest}.txt")


def prepare(out: Path, members: Sequence[Member]) -> None:
    """Create the folder `out` of a study and write the case files of its members to it. Raises UsageError if `out` is the
    folder of a single run."""
    from pellucid.case import dumps

    if RunFolder(out).is_of_a_run:
        raise UsageError(f"{out} is the folder of a run, whose report would be overwritten.\n    Choose another folder.")
    with explained(out), usable(out):
        for name in ("members", "cases", "logs"):
            (out / name).mkdir(parents=True, exist_ok=True)
        for member in members:
            file = places(out, member.digest).case
            if not file.is_file():
                write_text(file, dumps(member.case))


def outcome(out: Path, digest: str) -> Outcome | None:
    """Return the outcome of the member with a digest from its files in the folder `out` of the study: done, or failed with the
    message of the error stop; None if the member has not ended."""
    run = Run(places(out, digest).run)
    if stopped := run.stopped:
        return Outcome(FAILED, str(stopped.get("message", "the run stopped with an error")))
    try:
        return Outcome(DONE) if run.folder.ended and run.summary else None
    except PellucidError:  # a damaged summary: the run writes it again
        return None
