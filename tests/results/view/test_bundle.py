import hashlib
import json
from importlib.resources import files
from pathlib import Path

VIEWER = Path(__file__).parents[3] / "viewer"
SHIPPED = files("pellucid.results.view")


def test_the_program_is_built_from_its_sources():
    sources = [VIEWER / "build.mjs", VIEWER / "package.json", *sorted((VIEWER / "src").iterdir())]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    program = SHIPPED.joinpath("view.js").read_text(encoding="utf-8")
    assert f"sources {digest}" in program, "build it again: npm ci && npm run build in viewer"


def test_versions_are_fixed_and_lie_nowhere_else():
    lock = json.loads((VIEWER / "package-lock.json").read_text(encoding="utf-8"))
    wanted = json.loads((VIEWER / "package.json").read_text(encoding="utf-8"))["devDependencies"]
    for name, version in wanted.items():
        assert lock["packages"][f"node_modules/{name}"]["version"] == version
    assert not any("resolved" in package for package in lock["packages"].values())


def test_the_licence_of_three_js_is_shipped():
    assert "three.js" in SHIPPED.joinpath("LICENSE.three.txt").read_text(encoding="utf-8")


def test_the_program_does_not_end_its_own_element():
    assert "</script" not in SHIPPED.joinpath("view.js").read_text(encoding="utf-8").lower()
