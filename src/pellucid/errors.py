"""Errors that the user sees; the command line maps each class to its exit status."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace


class PellucidError(Exception):
    """Base class of all errors that a user can cause or correct; `exit_status` is the exit status of the command line."""

    exit_status = 2

    def __str__(self) -> str:
        return printable(super().__str__())


@dataclass(frozen=True)
class Problem:
    """An error of a case: what is wrong, where, and the remedy."""

    text: str
    """Description of the error, with the violated limit."""
    key: str = ""
    """Dotted key as the user writes it, such as `body.driver.material.density`; empty if no key is the cause."""
    value: object = None
    """The invalid value, if any."""
    remedy: str = ""
    """Remedy, such as "did you mean `density`?"."""
    line: int | None = None
    """Line number in the file, from 1."""
    setting: str = ""
    """The setting that is the cause, instead of a line of the file, such as `--set grid.cell=-1`."""

    def message(self, source: str = "") -> str:
        """Return the message for the user in one to three lines; source: name of the case file."""
        place = cut(self.setting, 200) or (f"{source}:{self.line}" if source and self.line else source or "")
        subject = self._subject()
        head = ": ".join(part for part in (place, subject or self.text) if part)
        return "\n    ".join(line for line in (head, self.text if subject else "", self.remedy) if line)

    def _subject(self) -> str:
        if not self.key or self.setting.startswith(f"--set {self.key}="):
            return ""
        key = cut(printable(self.key), 200)
        return key if self.value is None else f"{key} = {shown(self.value)}"


class CaseError(PellucidError):
    """Error for an invalid case, with all problems, each with file, line, key, value, limit and remedy."""

    def __init__(self, problems: "str | Problem | Sequence[Problem]", source: str = "") -> None:
        if isinstance(problems, str):
            problems = Problem(problems)
        self.problems: list[Problem] = [problems] if isinstance(problems, Problem) else list(problems)
        self.source = source
        super().__init__(self.problems, source)

    def __str__(self) -> str:
        messages = [problem.message(self.source) for problem in self.problems]
        if len(messages) > 1:
            messages.insert(0, f"{len(messages)} errors in {self.source or 'the case'}:")
        return printable("\n".join(messages))

    def blame(self, setting: str, line: int | None = None) -> "CaseError":
        """Return an error with the same problems that names a setting, such as `--set grid.cell=-1`, as the cause; line:
        line number of the setting in the case file, if the file contains the setting."""
        return CaseError([replace(problem, setting=setting, line=line) for problem in self.problems], self.source)


class UsageError(PellucidError):
    """Error for an invalid argument, such as an output folder that contains other files."""


class UnknownName(UsageError, KeyError):
    """Error for an unknown name; the message lists the known names."""

    def __str__(self) -> str:
        return printable(str(self.args[0]))


class RunStopped(PellucidError):
    """Error of a run that stopped (NaN, inverted or lost point, collapsed time step, energy error), or of a failed
    verification.

    `place`: step, time, body, point and its state, as far as known; settling_step if the run stopped before the first step.
    """

    exit_status = 3

    def __init__(self, message: str, **place: object) -> None:
        super().__init__(message)
        self.place = place


class Interrupted(PellucidError):
    """Error of a run that ended on SIGTERM or Ctrl-C after writing a checkpoint."""

    exit_status = 143

    def __init__(self, message: str = "The run was interrupted; a checkpoint was written.", by_keyboard: bool = False) -> None:
        super().__init__(message)
        self.by_keyboard = by_keyboard
        self.exit_status = 130 if by_keyboard else 143


class Terminated(KeyboardInterrupt):
    """Exception for SIGTERM outside the steps of a run. Incomplete files are removed, as after Ctrl-C; code that handles
    errors must not catch this exception."""


CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
"""Control characters except tabs and new lines. A terminal would interpret them, and a path must not contain a null
character."""


def printable(text: str) -> str:
    """Return a text with its control characters escaped, except tabs and new lines."""
    return CONTROL.sub(lambda found: repr(found[0])[1:-1], text)


def shown(value: object, limit: int = 60) -> str:
    """Return a value of a case as text, as a user would write it in the file, shortened to `limit` characters."""
    if isinstance(value, str):
        text = f'"{value}"'
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, dict):
        text = "{ " + ", ".join(f"{key} = {shown(item, limit)}" for key, item in value.items()) + " }"
    elif isinstance(value, (list, tuple)):
        text = "[" + ", ".join(shown(item, limit) for item in value) + "]"
    else:
        text = str(value)
    return cut(printable(text), limit)


def cut(text: str, limit: int = 60) -> str:
    """Return a text; if it is longer than `limit` characters, its beginning with " ...", `limit` characters in total."""
    return text if len(text) <= limit else text[: limit - 4] + " ..."
