"""The tutorials work: the fragments of a page form its file, and runs reproduce the numbers on the page."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from typer.testing import CliRunner

from pellucid import Run, load
from pellucid.case import parse_setting
from pellucid.cli import app
from pellucid.references.solids import stretched
from pellucid.running.launch import run_case

FOLDER = Path(__file__).parents[1] / "docs" / "tutorials"
NAMES = sorted(page.stem for page in FOLDER.glob("*.md") if page.stem != "index")
TISSUE = "body.tissue.material.young_modulus"


def run(name: str, out: Path, settings: dict[str, Any] | None = None) -> Run:
    return run_case(load(str(FOLDER / f"{name}.toml")).with_settings(settings or {}), out, report=False)


@pytest.fixture(scope="module")
def pressed(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return run("press-into-tissue", tmp_path_factory.mktemp("pressed") / "run")


def passed(run: Run) -> bool:
    assert run.metrics
    return all(metric.passed for metric in run.metrics.values())


@pytest.mark.parametrize("name", NAMES)
def test_the_pieces_of_a_page_are_its_file(name: str) -> None:
    pieces = re.findall(r"^```toml\n(.*?)^```", (FOLDER / f"{name}.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert len(pieces) > 3
    assert "\n".join(pieces) == (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_settings_of_a_page_are_those_of_its_case(name: str) -> None:
    case = load(str(FOLDER / f"{name}.toml"))
    lines = [line for line in (FOLDER / f"{name}.md").read_text(encoding="utf-8").splitlines() if "--set" in line]
    assert lines
    for line in lines:
        settings = re.findall(r"--set (?:'([^']+)'|([^'`\s]+))", line)
        case.with_settings(dict(parse_setting("".join(setting)) for setting in settings))


def test_the_zona_fails_about_the_tip(tmp_path: Path) -> None:
    done = run("pierce-an-oocyte", tmp_path / "run")
    assert passed(done)
    assert done.history["failed"][-1] == pytest.approx(319, abs=3)
    first = int(np.argmax(done.history["failed"] > 0))
    assert done.history["tip_y"][first] == pytest.approx(1.30e-6, abs=0.02e-6)
    zona = done.fields("zona")
    assert zona["position"][zona["failed"] > 0, 0].min() > 75e-6  # on the side of the pipette
    assert abs(done.history["tip_y"][-1] - 13.5e-6 * np.sin(0.4 * np.pi)) < 1e-12
    assert abs(done.history["energy_error"]).max() < 1e-4


def test_the_sheet_stops_the_drop(tmp_path: Path) -> None:
    done = run("drop-on-a-membrane", tmp_path / "run")
    assert passed(done)
    arrives = 0.5 * 1000 * np.pi * 0.0045**3 / 3 * 3**2
    assert done.history["kinetic_energy"][0] == pytest.approx(arrives, rel=1e-3)
    lowest = int(np.argmin(done.history["middle"]))
    assert done.history["middle"][lowest] == pytest.approx(-3.372e-3, abs=0.005e-3)
    assert done.history["time"][lowest] == pytest.approx(3.10e-3, abs=0.05e-3)
    assert -done.history["contact_work"][-1] / arrives == pytest.approx(0.18, abs=0.01)
    assert done.summary["conservation"]["momentum"] < 1e-15
    for time in done.times("drop"):  # no water below the middle of the sheet
        middle = np.interp(time, done.history["time"], done.history["middle"])
        assert done.fields("drop", float(time), ("position",))["position"][:, 2].min() > middle


def test_force_of_the_punch_is_that_of_the_page(pressed: Run) -> None:
    assert passed(pressed)
    assert pressed.history["force"][-1] == pytest.approx(-103.9e-3, abs=0.1e-3)


def test_whole_top_pressed_is_uniaxial_compression(tmp_path: Path) -> None:
    settings = {
        "support.base.fix": ["z"],
        "motion.punch.part.box.upper": [1, 1, 1],
        "steady.load_steps": 1,
        "steady.tolerance": 1e-6,
    }
    done = run("press-into-tissue", tmp_path / "run", settings)
    exact = 0.01**2 * stretched("coupled", 1e4, 0.45, 0.8).stress
    assert exact == pytest.approx(-249.930e-3, abs=1e-6)
    assert done.history["force"][-1] == pytest.approx(exact, rel=1e-6)


def test_force_is_proportional_to_the_modulus_that_fits(pressed: Run) -> None:
    """The law is linear in E, so that one run tells what the fit of the page must find."""
    depth, force, deviation = np.loadtxt(FOLDER / "punch.csv", delimiter=",", skiprows=2).T * 1e-3
    found = np.interp(-depth, -pressed.history["depth"], pressed.history["force"]) / deviation
    modulus = 1e4 * (found @ (force / deviation)) / (found @ found)
    half = 1.96e4 / np.sqrt(found @ found)
    assert modulus == pytest.approx(12.93e3, abs=10)
    assert half == pytest.approx(0.105e3, abs=0.01e3)


@pytest.mark.full
def test_fit_of_the_page_finds_its_modulus(tmp_path: Path) -> None:
    words = ["fit", str(FOLDER / "press-into-tissue.toml"), "--measured", str(FOLDER / "punch.csv"), "--probe", "force"]
    result = CliRunner().invoke(app, [*words, "--free", f"{TISSUE}=5kPa:20kPa", "--out", str(tmp_path / "fit")])
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "fit" / "estimates.json").read_text(encoding="utf-8"))
    assert found["estimates"][TISSUE]["value"] == pytest.approx(12.93e3, abs=5), "as the page says"


def test_the_vesicle_keeps_its_volume(tmp_path: Path) -> None:
    done = run("squeeze-a-vesicle", tmp_path / "run")
    assert passed(done)
    assert done.history["waist"][-1] == pytest.approx(0.6897, abs=1e-4)
    assert volume(done.fields("vesicle")["position"]) == pytest.approx(4 * np.pi / 3, rel=1e-6)


def volume(meridian: np.ndarray) -> float:
    """Return the volume enclosed by the surface of revolution of a meridian about z, from a spline through the meridian and
    its mirror image; meridian: positions from pole to pole, shape (n, 3)."""
    r, z = meridian[:, 0], meridian[:, 2]
    closed = np.column_stack([np.r_[r, -r[-2::-1]], np.r_[z, z[-2::-1]]])
    closed[-1] = closed[0]
    length = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))]
    curve = CubicSpline(length, closed, bc_type="periodic")
    at = np.linspace(0.0, length[len(r) - 1], 20001)
    return float(np.pi * np.trapezoid(curve(at)[:, 0] ** 2 * curve(at, 1)[:, 1], at))
