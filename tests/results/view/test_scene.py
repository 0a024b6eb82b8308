import zlib

import numpy as np
import pytest
from free_flight import free_flight
from view_scenes import TIMES, write_run

from pellucid.results.view import scene
from pellucid.results.view.scene import GONE, LEVELS, SHADES, scene_of
from pellucid.running.launch import run_case

PLENTY = 10**9


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("view") / "run")


class Reader:
    """Reads packed arrays as viewer/src/data.js does."""

    def __init__(self, packed):
        self._bytes, self._at = np.frombuffer(zlib.decompress(packed), np.uint8), 0

    def next(self, kind, count, before=None):
        size = np.dtype(kind).itemsize
        raw = self._bytes[self._at : self._at + size * count].reshape(size, count)
        self._at += size * count
        folded = sum(raw[k].astype(np.int64) << 8 * k for k in range(size))
        steps = (folded >> 1) ^ -(folded & 1)
        values = np.cumsum(steps) if before is None else before.astype(np.int64) + steps
        return (values % 2 ** (8 * size)).astype(kind)

    def series(self, kind, count, instants):
        found = []
        for _ in range(instants):
            found.append(self.next(kind, count, found[-1] if found else None))
        return found

    @property
    def done(self):
        return self._at == len(self._bytes)


def unpacked(found):
    """Cells, steps of places, shades by field and failures of each body, by name."""
    reader, bodies, instants = Reader(found.packed), {}, len(found.told["times"])
    for body in found.told["bodies"]:
        n = body["points"]
        cells = {}
        for name, shape in body["cells"].items():
            cells[name] = reader.next(np.uint32, int(np.prod(shape))).reshape(shape[::-1]).T
        steps = [flat.reshape(3, n).T for flat in reader.series(np.uint16, 3 * n, instants)]
        shades = {found.told["fields"][k]["word"]: reader.series(np.uint8, n, instants) for k in body["fields"]}
        bodies[body["name"]] = (body, cells, steps, shades, reader.series(np.uint8, n, instants) if body["failed"] else [])
    assert reader.done
    return bodies


def test_places_come_back_within_half_a_step(run):
    found = scene_of(run, PLENTY)
    assert found.told["times"] == TIMES.tolist()
    for name, (body, _, steps, _, _) in unpacked(found).items():
        for time, step in zip(TIMES, steps, strict=True):
            there = (step != GONE).all(axis=1)
            fields = run.fields(name, time)
            assert (there == (fields["mass"] > 0.0)).all()
            position = np.array(body["low"]) + step * np.array(body["span"]) / LEVELS
            tolerance = 0.5001 * np.array(body["span"]) / LEVELS
            assert (abs(position - fields["position"])[there] <= tolerance).all()


def test_fields_come_back_within_half_a_step_of_their_limits(run):
    found = scene_of(run, PLENTY)
    told = {field["word"]: field for field in found.told["fields"]}
    assert list(told) == ["speed", "displacement", "von Mises stress"]
    assert told["von Mises stress"]["unit"] == "Pa"
    limits = told["von Mises stress"]
    half = 0.5001 * (limits["high"] - limits["low"]) / SHADES
    for name, (*_, shades, _) in unpacked(found).items():
        for time, shade in zip(TIMES, shades["von Mises stress"], strict=True):
            values = limits["low"] + shade * (limits["high"] - limits["low"]) / SHADES
            true = np.clip(run.fields(name, time)["stress"][:, 0], limits["low"], limits["high"])
            assert abs(values - true).max() <= half


def test_values_beyond_the_limits_are_told(run):
    (stress,) = [field for field in scene_of(run, PLENTY).told["fields"] if field["word"] == "von Mises stress"]
    most = max(run.fields(name, time)["stress"].max() for name in ("core", "skin", "block") for time in TIMES)
    assert stress["most"] == pytest.approx(most, rel=1e-6)
    assert stress["high"] < stress["most"]


def test_surfaces_and_failed_points_are_those_of_the_run(run):
    bodies = unpacked(scene_of(run, PLENTY))
    for name in ("skin", "block"):
        _, cells, *_ = bodies[name]
        shown = cells["vertex"].ravel()[cells["triangles"]]
        assert sorted(map(sorted, shown)) == sorted(map(sorted, run.triangles(name).tolist()))
    assert (bodies["block"][1]["tetrahedra"] == run.cells("block").tetrahedra).all()
    for time, failed in zip(TIMES, bodies["skin"][4], strict=True):
        assert (failed == run.fields("skin", time)["failed"]).all()
    assert bodies["core"][0]["kind"] == "points"


def test_what_is_surrounded_is_seen_through_a_cut(run):
    axis, place = scene_of(run, PLENTY).told["cut"]
    assert axis == 1
    assert place == pytest.approx(1.0, abs=0.01)


def test_many_points_are_thinned_and_this_is_told(run, monkeypatch):
    whole = scene_of(run, PLENTY).told
    monkeypatch.setattr(scene, "MOST_POINTS", 200)
    told = scene_of(run, PLENTY).told
    sizes = [len(run.fields(body["name"])["position"]) for body in told["bodies"]]
    notes = []
    for body, before, size, kept in zip(told["bodies"], whole["bodies"], sizes, scene.shares(sizes), strict=True):
        assert body["points"] == kept
        if kept == size:
            assert body == before, "small bodies are whole, with their cells"
        else:
            assert body["radius"] > before["radius"]
            words = f"points of {body['name']} are shown, chosen at random, without cells"
            notes.append(f"{kept} of {size} {words}")
    assert told["notes"] == notes
    assert sum(scene.shares(sizes)) == 200
    monkeypatch.setattr(scene, "MOST_POINTS", 380)
    assert scene.shares([1, 1000, 100]) == [1, 279, 100]
    assert scene.shares([500, 1000]) == [190, 190]


def test_instants_are_thinned_to_the_budget_and_this_is_told(run):
    whole = scene_of(run, PLENTY)
    budget = int(0.8 * len(whole.packed))
    found = scene_of(run, budget)
    assert len(found.packed) <= budget
    assert 2 <= len(found.told["times"]) < len(TIMES)
    assert found.told["times"][-1] == TIMES[-1]
    assert found.told["notes"] == [f"{len(found.told['times'])} of 5 recorded frames are shown"]
    assert len(scene_of(run, 1).told["times"]) == 2


def test_a_thin_grid_is_seen_from_its_front(tmp_path, fake):
    told = scene_of(run_case(free_flight(), tmp_path / "run", report=False), PLENTY).told
    assert told["flat"]
    assert told["cut"] is None
    assert np.allclose(told["axes"], np.eye(3))


def test_a_tube_has_no_view(tmp_path):
    run = write_run(tmp_path / "run")
    tube = run.stored.grid.model_copy(update={"upper": (4.0, 0.0, 0.0)})
    run.stored = run.stored.model_copy(update={"grid": tube})
    assert scene_of(run, PLENTY) is None


def test_walls_are_surfaces_that_can_be_hidden(tmp_path):
    walls = [
        {"name": "floor", "point": (0, 0, 0.2), "normal": (0, 0, 1), "velocity": (0, 0, 0.1), "bodies": ["core"]},
        {"point": (0, 0, 1.55), "normal": (0, 0, -1), "bodies": ["core"]},
    ]
    run = write_run(tmp_path / "run", wall=walls)
    assert [wall.name for wall in run.stored.walls] == ["wall floor", "wall 2"]
    bodies = unpacked(scene_of(run, PLENTY))
    floor, cells, steps, shades, _ = bodies["wall floor"]
    assert floor["kind"] == "surface"
    assert not floor["hidden"], "it is seen from above"
    assert bodies["wall 2"][0]["hidden"], "it would cover the bodies"
    assert shades == {}
    assert cells["triangles"].tolist() == [[0, 1, 2], [0, 2, 3]]
    low, span = np.array(floor["low"]), np.array(floor["span"])
    height = [low[2] + span[2] * of_time[:, 2] / LEVELS for of_time in steps]
    assert np.array(height) == pytest.approx(np.tile(0.2 + 0.1 * TIMES[:, None], 4), abs=1e-4)
