"""Cases that go on from the state of an earlier run."""

import numpy as np
import pytest

from pellucid.case import Case, load, loads
from pellucid.errors import CaseError, UsageError
from pellucid.results import resume_case, run_case

TANK = """
schema = 1
title = "Two blocks in flight"
[grid]
lower = [0, 0, 0]
upper = [4, 2, 0]
cell = 0.25
functions = "quadratic-bspline"
[time]
end = 0.2
transfer = "TRANSFER"
[[body]]
name = "gas"
kind = "material-points"
shape = { box = { lower = [0.5, 0.5, 0], upper = [1.5, 1.5, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "fluid", density = 1.0, pressure = 1.0, eos = { kind = "ideal-gas", gamma = 1.4 } }
velocity = [1, 0, 0]
[[body]]
name = "block"
kind = "material-points"
shape = { box = { lower = [2.5, 0.5, 0], upper = [3.0, 1.5, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
velocity = [-1, 0.2, 0]
[output]
frames = 0.1
"""


def tank(transfer: str = "flip", **settings: object) -> Case:
    return loads(TANK.replace("TRANSFER", transfer)).with_settings(settings)


def going_on(case: Case, folder: object, **start: object) -> Case:
    return case.with_settings({"start": {"path": str(folder)} | start})


def fields(run, body):
    return run.fields(body)


@pytest.mark.parametrize("transfer", ["flip", "apic"])
def test_two_halves_are_the_whole(tmp_path, transfer):
    """From a checkpoint a run goes on as if it had not ended: the order of the points changes sums by rounding alone."""
    half = tank(transfer, **{"time.step": 1e-3})
    first = run_case(half.with_settings({"time.end": 0.1}), tmp_path / "first", report=False)
    second = run_case(going_on(half, first.out).with_settings({"time.end": 0.1}), tmp_path / "second", report=False)
    whole = run_case(half, tmp_path / "whole", report=False)
    for body in ("gas", "block"):
        for name in ("position", "velocity", "stress"):
            expected, found = fields(whole, body)[name], fields(second, body)[name]
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11 * abs(expected).max())
    assert second.summary["end_time"] == pytest.approx(0.1)


def test_a_frame_is_a_start_too_for_some_bodies(tmp_path):
    first = run_case(tank(), tmp_path / "first", report=False)
    case = going_on(tank(), first.out, time=0.1, body=["gas"]).with_settings({"body.block.velocity": [0, 0, 0]})
    second = run_case(case, tmp_path / "second", until=1e-9, report=False)
    at = first.fields("gas", 0.1)
    for name in ("position", "velocity", "density", "internal_energy"):
        np.testing.assert_allclose(second.fields("gas", 0.0)[name], at[name], rtol=1e-13)
    assert not second.fields("block", 0.0)["velocity"].any()


def test_the_balance_begins_with_the_state(tmp_path):
    first = run_case(tank(), tmp_path / "first", report=False)
    second = run_case(going_on(tank(), first.out), tmp_path / "second", report=False)
    for name in ("kinetic_energy", "internal_energy"):
        assert second.history[name][0] == pytest.approx(first.history[name][-1], rel=1e-12)
    assert abs(second.summary["conservation"]["energy"]) < 1e-3


def test_a_run_that_went_on_is_resumed_bit_for_bit(tmp_path):
    first = run_case(tank(), tmp_path / "first", report=False)
    part = {"box": {"lower": [2.1, 0, 0], "upper": [2.45, 2, 0]}}  # where the block is now, and was not
    motion = {
        "name": "grip",
        "body": "block",
        "part": part,
        "displacement": {"x": {"kind": "steady", "velocity": 0.1}},
    }
    case = going_on(tank(), first.out).with_settings({"motion": [motion]})
    expected = run_case(case, tmp_path / "whole", report=False)
    stopped = run_case(case, tmp_path / "stopped", until=0.1, report=False)
    (stopped.folder.checkpoint).stat()
    resumed = resume_case(stopped.out, report=False)
    assert resumed.folder.history.read_bytes() == expected.folder.history.read_bytes()


def test_a_run_is_not_resumed_from_another_start(tmp_path):
    first = run_case(tank(), tmp_path / "first", until=0.1, report=False)
    second = run_case(going_on(tank(), first.out), tmp_path / "second", until=0.1, report=False)
    resume_case(first.out, report=False)
    with pytest.raises(UsageError, match="the state of the earlier run from which it began"):
        resume_case(second.out, report=False)


def test_a_run_does_not_replace_the_one_that_it_starts_from(tmp_path):
    first = run_case(tank(), tmp_path / "first", until=0.1, report=False)
    with pytest.raises(UsageError, match="is the run from which the case starts"):
        run_case(going_on(tank(), first.out), first.out)
    assert first.history["time"][-1] == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    "case", ["basics/elastic-block-drop", "benet2015/compressed-vesicle", "benet2015/diffusion", "lian2014/airbag"]
)
def test_bodies_of_every_family_go_on(tmp_path, case):
    case = load(case).quick_variant()
    end = case.time.end / 10 if case.id != "lian2014/airbag" else case.time.end / 50
    first = run_case(case, tmp_path / "first", until=end, report=False)
    second = run_case(going_on(case, first.out), tmp_path / "second", until=end / 1e6, report=False)
    for body in (body.name for body in case.body):
        before, now = first.fields(body), second.fields(body, 0.0)
        assert before.keys() == now.keys()
        for name in before.keys() - ({"velocity"} if case.grid_or_none is None else set()):  # of films, by loads that are new
            scale = max(abs(before[name]).max(), 1e-300)
            np.testing.assert_allclose(now[name], before[name], rtol=0.0, atol=1e-9 * scale, err_msg=f"{body} {name}")


SOLID = {"kind": "linear-elastic", "density": 1.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
SHORTER = {
    "grid.upper": [2.5, 2, 0],
    "body.block.shape.box.lower": [2.0, 0.5, 0],
    "body.block.shape.box.upper": [2.5, 1.5, 0],
}


@pytest.mark.parametrize(
    ("start", "changes", "words"),
    [
        ({"path": "nowhere"}, {}, r"start\.path = .*nowhere.*\n.*there is no such folder"),
        ({"body": ["gass"]}, {}, r"there is no such body; those of the case are gas, block"),
        ({"time": 7.0}, {}, r"start\.time = 7(.|\n)*the last at 0\.2 s"),
        ({}, {"body.gas.points_per_cell": [1, 1, 1]}, r"body gas has 16 points here and had 64"),
        ({}, SHORTER, r"points of body block lie outside the grid(.|\n)*make the grid as large"),
        (
            {},
            {"body.gas.material": SOLID},
            r"material.kind = \"linear-elastic\"(.|\n)*a run in which it had material.kind = fluid",
        ),
    ],
)
def test_a_start_that_does_not_fit_is_an_error_of_the_case(tmp_path, start, changes, words):
    first = run_case(tank(), tmp_path / "first", report=False)
    with pytest.raises(CaseError, match=words):
        run_case(
            tank().with_settings({**changes, "start": {"path": str(first.out), **start}}), tmp_path / "second", report=False
        )
    assert not (tmp_path / "second").exists()
