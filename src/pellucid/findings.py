"""Errors found in a case, with their paths in its data, hints for misspelt names, and a dictionary that gives them."""

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from pellucid.errors import CaseError, Problem, UnknownName, cut

LONGEST = 100  # longest name [letters] for which a similar name is searched

Path = tuple[str | int, ...]
"""Path of a value through tables and lists: ("body", 0, "shape")."""


class Finding(NamedTuple):
    """An error in a case, found by its models: path of the key, what is wrong, and the remedy. A `CaseError` is built from
    findings."""

    path: Path  # path of the key in the data of the case
    text: str  # what is wrong
    remedy: str = ""  # what to do; empty if there is no remedy


class Reason(NamedTuple):
    """Reason why a part of a case cannot be computed, with a remedy; without the place in the case, unlike `Finding`."""

    text: str  # the reason, as part of a message
    remedy: str = ""  # what to do; empty if there is no remedy


class Refusal(ValueError):
    """Error that a model raises for data with which it cannot be used: reason and remedy. The model does not know its path
    in the case; the function that reads the case adds the path."""

    def __init__(self, text: str, remedy: str) -> None:
        super().__init__(f"{text}; {remedy}")
        self.reason = Reason(text, remedy)


class Disagreement(ValueError):
    """Error for parts of a case that contradict each other, with the list of findings."""

    def __init__(self, findings: list[Finding]) -> None:
        self.findings = findings
        super().__init__("; ".join(f"{'.'.join(map(str, found.path))}: {found.text}" for found in findings))


def refuse(findings: Iterable[Finding]) -> None:
    """Raise CaseError if there are findings: errors that could only be detected when the run was set up."""
    problems = [Problem(found.text, ".".join(map(str, found.path)), remedy=found.remedy) for found in findings]
    if problems:
        raise CaseError(problems)


def listed(names: Sequence[str]) -> str:
    """Return names as a comma-separated text."""
    return ", ".join(names)


def _are_numbered_apart(name: str, choice: str) -> bool:
    digits = re.findall(r"\d", name), re.findall(r"\d", choice)
    return all(digits) and digits[0] != digits[1]


def hint(name: str, choices: Sequence[str]) -> str:
    """Return the text "did you mean ..." with the name among `choices` that is similar to `name`, or that `name`
    abbreviates; an empty text if there is none.

    Names that differ in digits are never similar: c10 and c01 would both be close to c1. For names of more than LONGEST
    letters no choice is returned, because the duration of the search grows with the square of their length.
    """
    if len(name) > LONGEST:
        return ""
    lower = {choice.lower(): choice for choice in reversed(choices) if not _are_numbered_apart(name, choice)}
    close = difflib.get_close_matches(name.lower(), lower, 1) or [
        choice for choice in lower if len(name) > 1 and _abbreviates(name.lower(), re.split(r"\W|_", choice))
    ]
    return f"did you mean `{lower[min(close, key=len)]}`?" if close else ""


def absent(what: str, name: object, choices: Iterable[str]) -> str:
    """Return a message about an unknown name, with the known names (`choices`) and a likely match; `what`: beginning of the
    message, such as "the history has no column"."""
    known = list(choices)
    told = f"{what} `{cut(str(name))}`; available: {listed(known) or 'none'}"
    return "\n    ".join(line for line in (told, hint(str(name), known)) if line)


def _abbreviates(name: str, words: Sequence[str]) -> bool:
    """Return True if a name consists of beginnings of some of the words in their order, such as "cme" for the words "cell",
    "maximum", "entropy"."""
    name = name.lstrip("-_ ")
    if not name or not words:
        return not name
    starts = [n for n in range(len(name) + 1) if words[0].startswith(name[:n])]
    return any(_abbreviates(name[n:], words[1:]) for n in reversed(starts))


Value = TypeVar("Value")


class Named(dict[str, Value]):
    """A dictionary that raises `UnknownName`, with the list of known names, for an unknown name.

    what: beginning of the error message, such as "the history has no column"; values: the content of the dictionary.
    """

    def __init__(self, what: str, values: Mapping[str, Value]) -> None:
        super().__init__(values)
        self._what = what

    def __missing__(self, name: Any) -> Value:
        raise UnknownName(absent(self._what, name, self))
