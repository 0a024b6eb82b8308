"""Whose code a file is, and where an exception of users' code arose."""

import json
import sysconfig
from pathlib import Path

import numpy as np
import pytest

import pellucid
from pellucid.errors import RunStopped
from pellucid.smooth_step import smooth_step
from pellucid.users.users_code import WrongArray, as_array, failing_as, home_of, is_own, is_users, place_of, read_only

PACKAGE = Path(pellucid.__file__).parent


def test_whose_a_file_is():
    assert is_own(str(PACKAGE / "errors.py"))
    assert not is_own(f"{PACKAGE}_tissues/laws.py")  # an installed package may have such a name
    assert is_users(f"{PACKAGE}_tissues.py") == (not str(PACKAGE).startswith(sysconfig.get_paths()["purelib"]))
    assert is_users(__file__)
    for file in (json.__file__, np.__file__, "<string>"):
        assert not is_users(file)


def users(value):
    return smooth_step(json.loads(value))


@pytest.mark.parametrize("value", ["{", '"text"'])
def test_the_innermost_line_of_the_user_is_the_place(value):
    told = failing_as(lambda why: RunStopped(f"fails: {why}"))
    with pytest.raises(RunStopped, match=r"fails: (JSONDecodeError|TypeError): .*, at ") as stopped, told:
        users(value)
    line = users.__code__.co_firstlineno + 1
    assert str(stopped.value).endswith(f"{__file__}:{line} (`return smooth_step(json.loads(value))`)")
    assert place_of(stopped.value.__cause__) in str(stopped.value)


def test_an_error_of_pellucid_passes_as_it_is():
    with pytest.raises(RunStopped, match=r"^of pellucid$"), failing_as(lambda why: RunStopped("other")):
        raise RunStopped("of pellucid")


def test_arrays_of_users():
    for found in (3, np.float32(3.0), True, np.int64(2)):
        assert as_array(found, (), users).dtype == float
    kept = np.ones((2, 3))
    assert as_array(kept, (2, 3), users) is kept
    for found, words in (
        (None, "None"),
        ([[1], [1, 2]], "a list of rows of different lengths"),
        (1j, "a complex"),
        (kept, r"shape \(2, 3\)"),
    ):
        with pytest.raises(WrongArray, match=f"returns .*{words}; it must return one number, see {home_of(users)}"):
            as_array(found, (), users)
    view = read_only(kept)
    assert np.shares_memory(view, kept)
    assert not view.flags.writeable
    assert kept.flags.writeable
