"""Runs whose case was changed by hand in between: they go on with what may change, and say what else differs."""

import re

import numpy as np
import pytest
from free_flight import free_flight

from pellucid.errors import PellucidError, UsageError
from pellucid.results.storage import checkpoint, identity
from pellucid.running.launch import resume_case, run_case

pytestmark = pytest.mark.usefixtures("fake")


@pytest.fixture
def begun(tmp_path):
    return run_case(free_flight(), tmp_path / "run", until=0.5, report=False)


def edit(run, old, new):
    text = run.folder.case.read_text()
    assert old in text
    run.folder.case.write_text(text.replace(old, new))


def results(run):
    return {path: path.read_bytes() for path in run.out.rglob("*") if path.is_file() and path.name != "run.lock"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("points_per_cell = [5, 4, 1]", "points_per_cell = [5, 2, 1]", "body.gas.points_per_cell.1 was 4 and is now 2"),
        ('name = "gas"', 'name = "air"', 'body.air.name was "gas" and is now "air"'),
        ("gamma = 1.4", "gamma = 1.3", "body.gas.material.eos.gamma was 1.4 and is now 1.3"),
        ("cell = 0.5", "cell = 0.25", "grid.cell was 0.5 and is now 0.25"),
        ('name = "front"', 'name = "tip"', 'probe.tip.name was "front" and is now "tip"'),
        ("[[probe]]", '[[support]]\nwhere = "all-nodes"\nfix = ["z"]\n[[probe]]', "support was [] and is now [{ "),
    ],
)
def test_another_case_is_refused_with_what_differs_and_nothing_is_touched(begun, old, new, words):
    edit(begun, old, new)
    if old.startswith("name = "):
        edit(begun, 'body = "gas"', f'body = "{"air" if "air" in new else "gas"}"')
    before = results(begun)
    with pytest.raises(UsageError, match=rf"its case has changed:\n(.*\n)*    {re.escape(words)}(.*\n)*.*or start a new run"):
        resume_case(begun.out)
    assert results(begun) == before


def test_a_run_goes_on_with_settings_and_keeps_them(begun):
    run = resume_case(begun.out, report=False, settings={"time.end": 1.5, "time.step": 0.02, "energy.stop": 0.2})
    assert run.summary["end_time"] == 1.5
    assert (run.case.time.step, run.case.energy.stop) == (0.02, 0.2)
    assert resume_case(begun.out, report=False).finished


def test_an_end_that_is_past_is_refused(begun):
    before = results(begun)
    with pytest.raises(UsageError, match=r"time.end = 0.2 s, but .* has already reached 0.51 s"):
        resume_case(begun.out, settings={"time.end": 0.2})
    assert results(begun) == before


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"grid.cell": 0.25}, "grid.cell was 0.5 and is now 0.25"),
        ({"time.end": 2.0, "body.gas.velocity": [2, 0, 0]}, "body.gas.velocity.0 was 1.0 and is now 2.0"),
        ({"time.stepp": 0.1}, "did you mean `step`"),
    ],
)
def test_a_setting_that_makes_another_run_is_refused_and_nothing_is_touched(begun, settings, words):
    before = results(begun)
    with pytest.raises(PellucidError, match=re.escape(words)):
        resume_case(begun.out, settings=settings)
    assert results(begun) == before


def test_a_run_goes_on_with_another_end_step_and_output(begun):
    for old, new in (("end = 1.0", "end = 1.5"), ("step = 0.03", "step = 0.02"), ("history = 0.1", "history = 0.3")):
        edit(begun, old, new)
    edit(begun, "frames = 0.25", "frames = 0.5")
    run = resume_case(begun.out, report=False)
    assert run.summary["end_time"] == 1.5
    times = run.history["time"]
    assert times[:6] == pytest.approx([0.0, 0.12, 0.21, 0.3, 0.42, 0.51], abs=1e-9)  # as it began, every 0.1 s
    assert times[6:] == pytest.approx([0.61, 0.91, 1.21, 1.5])  # the multiples of 0.3 s in steps of 0.02 s
    assert run.times("gas") == pytest.approx([0.0, 0.27, 0.51, 1.01, 1.5])


def test_a_checkpoint_of_another_version_is_refused(begun, monkeypatch):
    monkeypatch.setattr(identity, "package_release", lambda: "99.0")
    with pytest.raises(UsageError, match=r"was started with pellucid .*, but this is version 99\.0\n.*Start a new run"):
        resume_case(begun.out)


def test_bodies_with_other_numbers_of_points_are_refused_before_anything_is_restored(begun, fake, monkeypatch):
    arrays, numbers = checkpoint.read_latest(begun.folder.checkpoint)
    numbers["recorder"]["identity"]["points"]["gas"] = 79
    checkpoint.write(begun.folder.checkpoint, arrays, numbers)
    monkeypatch.setattr(fake, "restore", lambda *_: pytest.fail("restored"))
    with pytest.raises(UsageError, match="body gas had 79 points and now has 80"):
        resume_case(begun.out)


def test_a_case_changed_before_the_first_checkpoint_is_begun_again_as_it_is_written(begun):
    for path in begun.folder.checkpoint.iterdir():
        path.unlink()
    edit(begun, "[output]", "# mine\n[output]")
    with pytest.warns(UserWarning, match="starts again from the beginning"):
        run = resume_case(begun.out, report=False)
    assert run.finished
    assert "# mine" in run.folder.case.read_text()
    assert np.all(np.diff(run.history["time"]) > 0.0)


def test_a_faulty_value_is_corrected_by_a_setting(begun):
    edit(begun, "end = 1.0", "end = -1.0")
    with pytest.raises(PellucidError, match=r"time\.end = -1\.0"):
        resume_case(begun.out)
    assert resume_case(begun.out, report=False, settings={"time.end": 0.75}).summary["end_time"] == 0.75
    assert resume_case(begun.out, report=False, settings={"time.end": 1.0}).finished


def test_a_setting_that_corrects_a_case_makes_no_other_run_of_it(begun):
    edit(begun, "gamma = 1.4", "gamma = -1.4")
    with pytest.raises(UsageError, match=r"gamma was 1\.4 and is now 1\.3"):
        resume_case(begun.out, settings={"body.gas.material.eos.gamma": 1.3})
    assert resume_case(begun.out, report=False, settings={"body.gas.material.eos.gamma": 1.4}).finished
