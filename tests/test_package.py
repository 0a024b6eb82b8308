"""Properties of the package before anything runs: version, types, light imports."""

import subprocess
import sys
from importlib.metadata import metadata, version
from importlib.resources import files

import pytest

import pellucid

HEAVY = ["numba", "scipy", "matplotlib", "h5py", "pint", "pyvista"]


def imported_by(code: str) -> set[str]:
    """Return the names of the modules that are imported in a new interpreter after running `code`."""
    report = f"{code}\nimport sys\nprint('\\n' + ' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def test_version_is_that_of_the_distribution() -> None:
    assert pellucid.__version__ == version("pellucid")


def test_license_is_stated() -> None:
    assert metadata("pellucid")["License-Expression"] == "BSD-3-Clause"


def test_types_are_announced() -> None:
    assert files("pellucid").joinpath("py.typed").is_file()


@pytest.mark.parametrize("name", [name for name in pellucid.__all__ if name != "__version__"])
def test_public_names_are_there_and_documented(name: str) -> None:
    assert getattr(pellucid, name).__doc__


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = pellucid.nonsense


@pytest.mark.parametrize(
    "code",
    [
        "import pellucid",
        "from pellucid import load\nload('gan2011/shock-tube')",
        "import pellucid.cli",
    ],
    ids=["import", "load", "cli"],
)
def test_import_is_light(code: str) -> None:
    assert imported_by(code) & set(HEAVY) == set()


def test_gallery_files_are_packaged() -> None:
    gallery = files("pellucid").joinpath("gallery")
    for group in ("gan2011", "basics"):
        assert any(entry.name.endswith(".toml") for entry in gallery.joinpath(group).iterdir())
