"""Digests of what a run has written, so that a file that was changed since is not gone on with."""

import hashlib
from typing import Any


class Written:
    """For each file the SHA-256 of all that was added to it so far."""

    def __init__(self) -> None:
        self._digests: dict[str, Any] = {}

    def add(self, name: str, data: bytes) -> None:
        """More was written to a file."""
        self._digests.setdefault(name, hashlib.sha256()).update(data)

    def to_data(self) -> dict[str, str]:
        """What a checkpoint keeps."""
        return {name: digest.hexdigest() for name, digest in self._digests.items()}
