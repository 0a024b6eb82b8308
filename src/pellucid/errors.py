"""Errors as seen by the user; the command line maps each class to its exit status."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace


class PellucidError(Exception):
    """Base of every error that a user can cause or mend; `exit_status` is what the command line returns."""

    exit_status = 2

    def __str__(self) -> str:
        return printable(super().__str__())


@dataclass(frozen=True)
class Problem:
    """An error of a case."""

    text: str
    """What is wrong, with the limit that was broken."""
    key: str = ""
    """Dotted key as the user writes it, such as `body.driver.material.density`; empty where no key is to blame."""
    value: object = None
    """What stands there, if anything."""
    remedy: str = ""
    """What to do, such as "did you mean `density`?"."""
    line: int | None = None
    """Line of the file, from 1."""
    setting: str = ""
    """The setting to blame instead of a line of the file, such as `--set grid.cell=-1`."""

    def message(self, source: str = "") -> str:
        """Return the message in one to three lines; `source` is the file's name."""
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
    """A case that cannot be run as it stands: every problem, each with file, line, key, value, limit and remedy."""

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
        """The same problems, laid at the door of a setting."""
        return CaseError([replace(problem, setting=setting, line=line) for problem in self.problems], self.source)


class UsageError(PellucidError):
    """An argument that makes no sense, such as an output folder with other files in it."""


class UnknownName(UsageError, KeyError):
    """A name under which nothing is found: the message lists those that there are."""

    def __str__(self) -> str:
        return printable(str(self.args[0]))


class RunStopped(PellucidError):
    """A run that stopped itself (NaN, inverted or lost point, collapsed step, energy error), or failed verification.

    `place` says where, as far as it is known: step, time, body, point and its state; settling_step before the first.
    """

    exit_status = 3

    def __init__(self, message: str, **place: object) -> None:
        super().__init__(message)
        self.place = place


class Interrupted(PellucidError):
    """A run that left on SIGTERM or Ctrl-C after writing a checkpoint."""

    exit_status = 143

    def __init__(self, message: str = "The run was interrupted; a checkpoint was written.", by_keyboard: bool = False) -> None:
        super().__init__(message)
        self.by_keyboard = by_keyboard
        self.exit_status = 130 if by_keyboard else 143


class Terminated(KeyboardInterrupt):
    """SIGTERM outside of the steps of a run: like Ctrl-C it undoes what is half written, and is no error to be caught."""


CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
"""All but tabs and new lines: a terminal would obey them, and no path may have a null."""


def printable(text: str) -> str:
    """A text with its control characters spelt out, which a terminal would obey: all but tabs and new lines."""
    return CONTROL.sub(lambda found: repr(found[0])[1:-1], text)


def shown(value: object, limit: int = 60) -> str:
    """A value as a user would write it, cut to `limit` characters."""
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
    """A text, or its beginning, `limit` characters with the dots that stand for the rest."""
    return text if len(text) <= limit else text[: limit - 4] + " ..."
