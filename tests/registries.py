"""What tests share that register kinds: nothing of it stays behind."""

from collections.abc import Iterator
from contextlib import contextmanager

from pellucid import extensions
from pellucid.registry import Registry
from pellucid.state import FIELDS


@contextmanager
def forgotten_afterwards() -> Iterator[None]:
    """What is registered inside, or loaded as an extension, is forgotten at the end."""
    registries = [(registry, dict(registry._entries)) for registry in Registry.every]
    loaded, fields = dict(extensions._loaded), dict(FIELDS)
    try:
        yield
    finally:
        for registry, entries in registries:
            registry._entries = entries
        for before, now in ((loaded, extensions._loaded), (fields, FIELDS)):
            now.clear()
            now.update(before)
        Registry.changes += 1
