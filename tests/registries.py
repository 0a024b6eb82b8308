"""Removal of the kinds and fields that tests register."""

from collections.abc import Iterator
from contextlib import contextmanager

from pellucid.registry import Registry
from pellucid.state import FIELDS
from pellucid.users import users_code


@contextmanager
def forgotten_afterwards() -> Iterator[None]:
    """Remove at the end of the block all kinds, extensions and fields that were registered in it."""
    registries = [(registry, dict(registry.entries)) for registry in Registry.every]
    loaded, fields = dict(users_code._loaded), dict(FIELDS)
    try:
        yield
    finally:
        kept = [(entries, registry.entries) for registry, entries in registries]
        every = [*kept, (loaded, users_code._loaded), (fields, FIELDS)]
        if changed := [(before, now) for before, now in every if before != now]:
            for before, now in changed:
                now.clear()
                now.update(before)
            Registry.changes += 1
