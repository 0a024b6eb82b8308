"""The benchmark: its problem, its measurements, and agreement of the peer scripts with the same problem."""

import importlib
import importlib.util
import json
import sys
from io import StringIO
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from pellucid import Simulation
from pellucid.approximants import GRID_FUNCTIONS
from pellucid.bench import bench, table, whole
from pellucid.bench.contact import WHICH, contact_case
from pellucid.bench.machine import triad_bandwidth
from pellucid.bench.measure import measure
from pellucid.bench.problem import MATERIALS, bench_case, case_of
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.errors import UsageError

SOME_VARIANTS = [{"body": "ideal-gas", "functions": "trilinear", "transfer": "apic"}, {"body": "membrane-elements"}]
SOME_PASSES = [{"body": "ideal-gas"}, {"body": "membrane-points"}]
PEER_SCRIPTS = Path(__file__).parents[1] / "benchmarks" / "peers"


@pytest.fixture(scope="module")
def block() -> ModuleType:
    """Return the module `block` that the peer scripts share."""
    spec = importlib.util.spec_from_file_location("block", PEER_SCRIPTS / "block.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules["block"] = module  # its dataclass looks itself up
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def result() -> dict[str, Any]:
    """Return the result of a benchmark with a thousand points and two of the variants, which compile kernels of their own.
    The first measurement of each kind runs in a process of its own, as in a real benchmark; later ones run here, since the
    start of a process takes longer than a measurement."""
    began, apart = set[str](), whole._in_a_process

    def once_apart(module: str, request: dict[str, Any]) -> dict[str, Any]:
        if module not in began:
            began.add(module)
            return apart(module, request)
        of = importlib.import_module(f"pellucid.bench.{module}")
        found: dict[str, Any] = json.loads(json.dumps(of.measure(**request)))
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(whole, "_in_a_process", once_apart)
        patch.setattr(whole, "VARIANTS", SOME_VARIANTS)
        patch.setattr(whole, "PASSES", SOME_PASSES)
        patch.setattr(whole, "THREADS_POINTS", (1000,))
        return bench(points=[1000], steps=2, threads=1)


def shown(result: dict[str, Any]) -> str:
    console = Console(width=200, record=True, file=StringIO())
    console.print(table(result))
    return console.export_text()


@pytest.mark.parametrize("body", MATERIALS)
@pytest.mark.parametrize("points", [64, 10_000, 1_000_000])
def test_problem_has_about_the_points_asked_for(body: str, points: int) -> None:
    counts = bench_case(body, points).grid.counts()
    assert np.prod(counts) * 8 == pytest.approx(points, rel=0.1)


@pytest.mark.parametrize(("body", "law"), [("ideal-gas", "ideal-gas"), ("hypoelastic", "hypoelastic")])
def test_peers_start_from_the_same_state(block: ModuleType, body: str, law: str) -> None:
    frame = Simulation(bench_case(body, 1000)).bodies[0].frame()
    theirs = block.make_block(1000, law)

    def in_order(position: np.ndarray) -> np.ndarray:
        return np.lexsort(np.round(position / block.CELL, 6).T)

    mine, other = in_order(frame["position"]), in_order(theirs.position)
    np.testing.assert_allclose(frame["position"][mine], theirs.position[other], rtol=1e-12)
    np.testing.assert_allclose(frame["velocity"][mine], theirs.velocity[other], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(frame["mass"], theirs.mass, rtol=1e-12)


@pytest.mark.slow
def test_every_body_is_measured(result: dict[str, Any]) -> None:
    assert [row["body"] for row in result["bodies"]] == list(MATERIALS)
    for row in result["bodies"]:
        assert row["points"] == 1000
        assert row["point_steps_per_second"] == pytest.approx(1000 / row["seconds_per_step"])
        assert row["bytes_per_point"] >= 0.0


@pytest.mark.slow
def test_other_functions_transfers_and_membranes_are_measured(result: dict[str, Any]) -> None:
    found = [(row["body"], row["functions"], row["transfer"]) for row in result["variants"]]
    assert found == [("ideal-gas", "trilinear", "apic"), ("membrane-elements", "trilinear", "flip")]
    assert all(row["points"] == pytest.approx(1000, rel=0.05) for row in result["variants"])


@pytest.mark.slow
def test_passes_are_measured_alone(result: dict[str, Any]) -> None:
    names = [set(row["passes"]) for row in result["passes"]]
    common = {"particle to grid", "velocities", "velocities and momentum"}
    assert names == [{*common, "straining"}, {*common, "gradients"}]
    for row in result["passes"]:
        for one in row["passes"].values():
            assert one["bytes_per_second"] * one["seconds_per_point"] == pytest.approx(one["bytes_per_point"])
    # read: place, velocity, mass, volume, stress and energy; kept: place, volume, stress and energy
    assert result["passes"][0]["passes"]["straining"]["bytes_per_point"] == 8 * (3 + 3 + 1 + 1 + 7 + 3 + 1 + 7)


@pytest.mark.slow
def test_the_gas_is_measured_with_numbers_of_threads(result: dict[str, Any]) -> None:
    assert [(row["body"], row["points"], row["threads"]) for row in result["threads"]] == [("ideal-gas", 1000, 1)]
    rows = [
        {**result["threads"][0], "threads": number, "seconds_per_step": seconds} for number, seconds in ((1, 0.5), (2, 0.4))
    ]
    assert "1.25" in shown({**result, "threads": rows}).split("speed-up over one thread")[1]


@pytest.mark.parametrize("variant", whole.VARIANTS, ids=lambda variant: "-".join(variant.values()))
def test_variants_are_cases_of_about_the_points_asked_for(variant: dict[str, str]) -> None:
    sim = Simulation(case_of(points=1000, **variant))
    assert sim.bodies[0].n_points == pytest.approx(1000, rel=0.05)


def test_variants_have_every_function() -> None:
    assert {variant.get("functions", "trilinear") for variant in whole.VARIANTS} == set(GRID_FUNCTIONS)


@pytest.mark.slow
def test_parts_make_up_the_step(result: dict[str, Any]) -> None:
    for row in [*result["bodies"], *result["variants"]]:
        assert {"sort", "scatter", "grid"} <= set(row["parts"])
        assert all(share >= 0.0 for share in row["parts"].values())
        assert sum(row["parts"].values()) == pytest.approx(1.0)


@pytest.mark.slow
def test_contact_is_measured_beside_the_two_alone(result: dict[str, Any]) -> None:
    row = result["contact"]
    assert row["points"] == 1000
    assert row["elements"] == 100
    seconds = row["seconds_per_step"]
    assert row["ratio"] == pytest.approx(seconds["together"] / (seconds["sheet"] + seconds["block"]))


@pytest.mark.slow
def test_forces_of_a_meshless_solid_are_measured(result: dict[str, Any]) -> None:
    row = result["solid"]
    assert row["points"] == pytest.approx(1000, rel=0.5)  # a cube of whole cubes
    assert 4.0 < row["nodes_per_point"] < 40.0
    # a gradient in single precision of each node at a point, and what belongs to the point alone
    assert 12.0 * row["nodes_per_point"] < row["bytes_per_point"] < 14.0 * row["nodes_per_point"] + 400.0
    assert set(row["forms"]) == {"averaged", "pointwise"}
    for form in row["forms"].values():
        assert form["point_updates_per_second"] == pytest.approx(row["points"] / form["seconds_per_update"])
        assert 0.0 < form["moved_bytes_per_second"] < 1e13


@pytest.mark.slow
def test_steps_of_films_are_measured(result: dict[str, Any]) -> None:
    (row,) = result["films"]
    assert row["points"] == 642
    assert row["steps"] >= 2
    assert row["seconds_per_step"] > 0.0
    assert sum(row["parts"].values()) == pytest.approx(1.0)
    assert row["parts"]["matrix"] > 0.0
    assert row["parts"]["iteration"] > 0.0


@pytest.mark.parametrize("points", [1000, 10_000])
def test_the_block_presses_on_all_of_the_sheet(points: int) -> None:
    sim = Simulation(contact_case(points, WHICH["together"]))
    for _ in range(5):
        sim.step()
    sheet, block = sim.bodies
    touching = sum(len(places) for surface, places in sim.parts.only(SurfacePairs).touching() if surface.is_sheet)
    assert block.n_points == pytest.approx(points, rel=0.1)
    cells = len(sheet.cells().quadrilaterals) ** 0.5 / 2
    assert touching >= (cells + 1) ** 2
    assert sim.budget.sums["contact_work"] < 0.0


@pytest.mark.slow
def test_result_is_json_and_has_a_table(result: dict[str, Any]) -> None:
    json.dumps(result, allow_nan=False)
    text = shown(result)
    assert "M point-steps/s" in text
    assert all(body in text for body in MATERIALS)
    assert "a membrane sheet" in text
    assert "membrane-elements" in text
    assert "a block in contact with a sheet" in text
    assert "forces of a meshless solid" in text
    assert "a film in space" in text


def test_bandwidth_is_that_of_a_computer() -> None:
    assert 1e8 < triad_bandwidth(threads=1, length=1_000_000) < 1e13


def test_missing_peer_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bare = tmp_path / "python"
    bare.write_text("#!/bin/sh\necho \"ModuleNotFoundError: No module named 'taichi'\" >&2\nexit 1\n")
    bare.chmod(0o755)
    monkeypatch.setenv(whole.INTERPRETER_VARIABLE, str(bare))
    rows = whole.run_peers(points=1000, steps=1, threads=1)
    assert {row["peer"] for row in rows} == set(whole.PEERS)
    assert all("No module named" in row["missing"] for row in rows)
    assert "not run" in shown(
        {
            "machine": MACHINE,
            "bodies": [],
            "variants": [],
            "passes": [],
            "threads": [],
            "contact": CONTACT,
            "solid": SOLID,
            "films": [],
            "peers": rows,
        }
    )


def test_ratio_to_a_peer_is_of_equal_problems(monkeypatch: pytest.MonkeyPatch) -> None:
    row = {"body": "hypoelastic", "points": 1000, "point_steps_per_second": 30.0}
    peer = {"peer": "taichi", "law": "hypoelastic", "points": 1000, "point_steps_per_second": 5.0, "threads": 2}
    assert whole._with_ratio(peer, [row])["ratio"] == 6.0
    assert "ratio" not in whole._with_ratio({**peer, "points": 8000}, [row])


CONTACT = {"elements": 1, "points": 8, "seconds_per_step": {"sheet": 1.0, "block": 1.0, "together": 2.0}, "ratio": 1.0}
SOLID = {"points": 8, "nodes": 8, "build_seconds": 1.0, "build_bytes": 1, "forms": {}}
MACHINE = {"processor": "a", "threads": 1, "triad_bytes_per_second": 1e10, "pellucid": "0", "numba": "0"}


@pytest.mark.parametrize("body", MATERIALS)
def test_small_bodies_survive_blocks_of_hundreds_of_steps(body: str) -> None:
    """As those of the first size do, the waves of which break."""
    assert measure(body, 1000, steps=100, threads=None)["steps"] == 100


def test_sizes_without_sense_are_refused() -> None:
    with pytest.raises(UsageError, match="between 8 and"):
        bench([1], steps=1)
