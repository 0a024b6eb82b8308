"""The user-defined pass over points in CONTRIBUTING.md works as written there."""

import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from small_cases import box, simulation

PAGE = Path(__file__).parents[1] / "CONTRIBUTING.md"
MOST_LINES = 60


@pytest.fixture(scope="module")
def code():
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    return next(block for block in blocks if "class Diffusion" in block)


@pytest.fixture(scope="module")
def diffusion(code, tmp_path_factory):
    path = tmp_path_factory.mktemp("walk") / "diffusing_scalar.py"
    path.write_text(code, encoding="utf-8")
    spec = spec_from_file_location("diffusing_scalar", path)
    module = sys.modules[spec.name] = module_from_spec(spec)  # as an import does: kernels on disk name their modules
    spec.loader.exec_module(module)
    yield module.Diffusion
    del sys.modules[spec.name]


def test_it_is_short(code):
    lines = [line for line in code.splitlines() if line.strip() and not line.startswith(("from ", "import "))]
    assert len(lines) < MOST_LINES


def amplitude_after(diffusion, cells, time=0.05):
    """Return the amplitude of a cosine over the unit length after diffusion with D = 1 over a time, divided by its exact
    value exp(-π² t)."""
    sim = simulation(box((0, 0, 0), (cells, 1, 1)), counts=(cells, 1, 1))
    body = sim.bodies[0]
    wave = np.cos(np.pi * body.arrays["position"][:, 0] / cells)
    c = 2.0 + wave
    scalar, steps = diffusion(body, c, float(cells**2)), 16 * cells**2 // 10
    for _ in range(steps):
        scalar.step(time / steps)
    assert c.sum() == pytest.approx(2.0 * len(c), rel=1e-13), "what there is stays"
    return float(wave @ c / (wave @ wave) * np.exp(np.pi**2 * time))


def test_a_cosine_decays_as_it_should(diffusion):
    """Explicit Euler at a fixed D dt/h² = 0.03: all errors are of second order in the cell."""
    errors = [abs(amplitude_after(diffusion, cells) - 1.0) for cells in (6, 12, 24)]
    assert errors[-1] < 3e-3
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.2)
