"""Times of a step that a machine learns from runs."""

import pytest
from small_cases import GAS, SOLID, box, case

from pellucid.case import load
from pellucid.errors import UsageError
from pellucid.progress import Progress
from pellucid.running.forecast import Paces, StepTime, ToldOnTheWay, lines, pace_of, size_of
from pellucid.running.step_number import Foretold

UNKNOWN = (
    "time: unknown, because no similar case has run on this machine yet; an estimate follows after the first second of the run"
)


def block(per_axis, material=SOLID, name="block"):
    """A block of so many points along each axis."""
    points = (per_axis, per_axis, per_axis)
    return case(box((0, 0, 0), (1, 1, 1), material, points, name), counts=(2, 2, 2))


def taught(folder, cases, seconds):
    """Return the paces of a machine on which a step of each of some cases took so long [s]."""
    paces = Paces(folder)
    for each, time in zip(cases, seconds, strict=True):
        paces.learn(each, 1000, 1000.0 * time)
    return paces


def test_nothing_is_known_at_first(tmp_path):
    assert Paces(tmp_path / "paces").seconds_of_a_step(block(10)) is None


def test_the_same_case_takes_the_same_time(tmp_path):
    assert taught(tmp_path, [block(10)], [3e-3]).seconds_of_a_step(block(10, name="other")) == StepTime(3e-3, 3e-3)


def test_a_size_between_two_takes_a_time_between_theirs(tmp_path):
    paces = taught(tmp_path, [block(10), block(20)], [1e-3, 8e-3])
    least, most = paces.seconds_of_a_step(block(15))
    assert least == most == pytest.approx(1e-3 * 1.5**3, rel=0.02)


@pytest.mark.parametrize("points", [5, 20])
def test_larger_and_smaller_cases_take_a_time_between_two(tmp_path, points):
    """As long as the one that ran, or by as much longer or shorter as they are larger or smaller."""
    least, most = taught(tmp_path, [block(10)], [1e-3]).seconds_of_a_step(block(points))
    assert sorted((1e-3, 1e-3 * (points / 10) ** 3)) == pytest.approx([least, most], rel=0.25)


def test_bodies_of_other_kinds_tell_nothing(tmp_path):
    assert taught(tmp_path, [block(10)], [1e-3]).seconds_of_a_step(block(10, GAS)) is None


def test_short_runs_teach_nothing(tmp_path):
    paces = Paces(tmp_path)
    paces.learn(block(10), 5, 100.0)
    paces.learn(block(10), 1000, 0.01)
    assert paces.seconds_of_a_step(block(10)) is None


def test_the_last_runs_count(tmp_path):
    times = [1.0] * 9 + [1e-3, 3e-3, 2e-3]
    assert taught(tmp_path, [block(10)] * 12, times).seconds_of_a_step(block(10)).most == pytest.approx(2e-3)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "[[-1.0, 1.0]]", "[[1.0, 0.0]]", '[["x", 1]]', "[[1, 2, 3]]", "null"])
def test_a_damaged_memory_is_none(tmp_path, text):
    paces = taught(tmp_path, [block(10)], [1e-3])
    next(tmp_path.glob("*.json")).write_text(text)
    assert paces.seconds_of_a_step(block(10)) is None
    paces.learn(block(10), 1000, 2.0)
    assert paces.seconds_of_a_step(block(10)).most == pytest.approx(2e-3)


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path):
    (tmp_path / "file").write_text("")
    paces = Paces(tmp_path / "file" / "paces")
    paces.learn(block(10), 1000, 1.0)
    assert paces.seconds_of_a_step(block(10)) is None


def test_without_a_folder_nothing_is_known(monkeypatch):
    def homeless():
        raise UsageError("there is no home folder")

    monkeypatch.setattr("pellucid.running.forecast.cache_folder", homeless)
    assert pace_of(block(10)) is None


def test_the_size_goes_with_the_points():
    assert size_of(block(20)) / size_of(block(10)) == pytest.approx(8.0, rel=0.05)


@pytest.mark.parametrize(
    ("each", "words"),
    [
        (None, UNKNOWN),
        (StepTime(0.01, 0.01), "time: about 2.0 s on this machine, excluding set-up, compilation and report"),
        (StepTime(0.01, 0.02), "time: about 2.8 s on this machine, excluding set-up, compilation and report"),
        (StepTime(0.01, 0.1), "time: between 2.0 s and 20.0 s on this machine, excluding set-up, compilation and report"),
    ],
)
def test_steps_and_time_are_said_in_two_lines(each, words):
    steps, time = lines(block(10), Foretold(5e-3, 200, "limited by body `block` (wave): waves"), each)
    assert steps == "steps: about 200 of 0.005 s, limited by body `block` (wave): waves"
    assert time == words


def test_of_a_relaxation_the_time_of_a_step_is_told():
    steps, time = lines(block(10), Foretold(float("nan"), float("nan"), "steady states"), StepTime(4e-3, 4e-3))
    assert (steps, time) == ("steps: steady states", "time: about 4 ms per step on this machine")


def test_of_a_factored_search_no_time_is_told():
    """The time of a step of an earlier run can be that of a relaxation."""
    _, time = lines(load("basics/shelf"), Foretold(float("nan"), float("nan"), "steady states"), StepTime(4e-3, 4e-3))
    assert time == "time: not known in advance; the run shows load step, iteration and estimated error"


def test_of_a_path_the_load_factor_is_told():
    case = load("basics/shelf").with_settings({"steady.control": "arc-length"})
    _, time = lines(case, Foretold(float("nan"), float("nan"), "a path"), None)
    assert time == "time: not known in advance; the run shows equilibrium, iteration and load factor"


def told_on_the_way(monkeypatch, *events):
    """Return the notes of a run with steps of 0.1 s that reports after each event: wall-clock seconds of steps, or "compiling"
    before the step that follows."""

    class Notes(Progress):
        def __init__(self):
            self.texts = []

        def note(self, text):
            self.texts.append(text)

    notes, now, step = Notes(), 0.0, 0
    progress = ToldOnTheWay(notes)
    progress.begin("running", 10.0)
    for event in events:
        if event == "compiling":
            progress.compiling("kernel", 1, 1)
            progress.compiled()
            continue
        now, step = now + event, step + 1
        monkeypatch.setattr("pellucid.running.forecast.monotonic", lambda at=now: at)
        progress.update(step=step, time=0.1 * step, dt=0.1, points=1, energy_error=0.0)
    return notes.texts


def test_what_was_not_known_is_told_after_a_second_and_some_steps(monkeypatch):
    assert not told_on_the_way(monkeypatch, *[0.05] * 15)
    assert not told_on_the_way(monkeypatch, *[0.5] * 10)
    (text,) = told_on_the_way(monkeypatch, *[0.5] * 20)
    assert text == "time: about 44.5 s remaining, estimated at step 11"


def test_compilation_and_the_steps_in_which_it_falls_are_left_out(monkeypatch):
    first = ["compiling", 60.0, 0.2, "compiling", 25.0, 8.0]
    (text,) = told_on_the_way(monkeypatch, *first, *[0.2] * 20)
    assert text == "time: about 17.4 s remaining, estimated at step 13"
