import tomllib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pellucid import catalogue
from pellucid.case.toml import key_lines


def test_every_form_of_key_has_its_line() -> None:
    text = '''\
# a comment with [brackets] and "quotes
title = "a # b = [c]"  # trailing
a.b = 1
"quoted key" = 2

[grid]
lower = [0,
  1,  # inside
  2]
[[body]]
name = 'one'
shape = { box = { lower = [0, 0], upper = [1, 1] } }
  [body.material]
  kind = """
many
lines = "\\"" """
  density = 1.0
[[body]]
name = "two"
date = 1979-05-27 07:32:00
'''
    tomllib.loads(text)
    lines = key_lines(text)
    assert lines[("title",)] == 2
    assert lines[("a", "b")] == lines[("a",)] == 3
    assert lines[("quoted key",)] == 4
    assert lines[("grid",)] == 6
    assert [lines[("grid", "lower", i)] for i in range(3)] == [7, 8, 9]
    assert lines[("body", 0)] == 10
    assert lines[("body", 0, "shape", "box", "upper", 1)] == 12
    assert lines[("body", 0, "material")] == 13
    assert lines[("body", 0, "material", "kind")] == 14
    assert lines[("body", 0, "material", "density")] == 17
    assert lines[("body", 1)] == 18
    assert lines[("body", 1, "date")] == 20


def paths(data: Any, path: tuple = ()) -> set[tuple]:
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return {path} - {()} | {deeper for key, item in items for deeper in paths(item, (*path, key))}


@pytest.mark.parametrize("case", catalogue.ids())
def test_no_key_of_a_gallery_case_is_missed(case: str) -> None:
    text = catalogue.text(case)
    assert set(key_lines(text)) == paths(tomllib.loads(text))


keys = st.from_regex(r"\A[A-Za-z0-9_-]{1,8}\Z") | st.text(max_size=6)
scalars = st.one_of(st.integers(-99, 99), st.booleans(), st.text(max_size=12), st.floats(allow_nan=False, allow_infinity=False))
values = st.recursive(scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=3))


@given(st.dictionaries(keys, values, max_size=4))
def test_no_key_of_any_text_is_missed(data: dict[str, Any]) -> None:
    import tomlkit

    text = tomlkit.dumps(data)
    assert set(key_lines(text)) == paths(tomllib.loads(text))
