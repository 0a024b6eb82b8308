"""What tests share that register kinds: nothing of it stays behind."""

from collections.abc import Iterator
from contextlib import contextmanager

from pellucid.registry import Registry
from pellucid.state import FIELDS
from pellucid.users import extensions


@contextmanager
def forgotten_afterwards() -> Iterator[None]:
    """What is registered inside, or loaded as an extension, is forgotten at the end."""
    registries = [(registry, dict(registry.entries)) for registry in Registry.every]
    loaded, fields = dict(extensions._loaded), dict(FIELDS)
    try:
        yield
    finally:
        kept = [(entries, registry.entries) for registry, entries in registries]
        every = [*kept, (loaded, extensions._loaded), (fields, FIELDS)]
        if changed := [(before, now) for before, now in every if before != now]:
            for before, now in changed:
                now.clear()
                now.update(before)
            Registry.changes += 1
