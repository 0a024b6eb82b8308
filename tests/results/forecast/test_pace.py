"""What a machine learns of the time of a step from runs."""

import pytest
from small_cases import GAS, SOLID, box, case

from pellucid.results.forecast.on_the_way import ToldOnTheWay
from pellucid.results.forecast.pace import STEP, Paces, counts_of
from pellucid.results.forecast.steps import Foretold
from pellucid.results.forecast.words import lines


def block(edge, material=SOLID, **more):
    return case(box((0, 0, 0), (edge, edge, edge), material), counts=(10, 10, 10), **more)


def taught(folder, cases, seconds):
    """What a machine knows on which a step of each of some cases took so long [s]."""
    paces = Paces(folder)
    for each, time in zip(cases, seconds, strict=True):
        paces.learn(each, 1000, 1000.0 * time)
    return paces


def test_nothing_is_known_at_first(tmp_path):
    assert Paces(tmp_path / "paces").seconds_of_a_step(block(2)) is None


def test_the_same_case_takes_the_same_time(tmp_path):
    assert taught(tmp_path, [block(2)], [3e-3]).seconds_of_a_step(block(2)) == pytest.approx(3e-3)


def test_steps_and_points_have_times_of_their_own(tmp_path):
    overhead, point = 4e-4, 1e-7
    known = [block(edge) for edge in (1, 2, 4)]
    paces = taught(tmp_path, known, [overhead + point * 8 * edge**3 for edge in (1, 2, 4)])
    assert paces.seconds_of_a_step(block(8)) == pytest.approx(overhead + point * 8 * 8**3, rel=0.01)


def test_bodies_of_other_kinds_teach_nothing(tmp_path):
    assert taught(tmp_path, [block(2)], [1e-3]).seconds_of_a_step(block(2, GAS)) is None


def test_far_fewer_points_teach_nothing(tmp_path):
    paces = taught(tmp_path, [block(2)], [1e-3])
    assert paces.seconds_of_a_step(block(4)) is not None
    assert paces.seconds_of_a_step(block(8)) is None


def test_short_runs_teach_nothing(tmp_path):
    paces = Paces(tmp_path)
    paces.learn(block(2), 5, 100.0)
    paces.learn(block(2), 1000, 0.01)
    assert paces.seconds_of_a_step(block(2)) is None


def test_the_last_runs_count(tmp_path):
    times = [1.0] * 3 + [1e-3] * 6
    assert taught(tmp_path, [block(2)] * 9, times).seconds_of_a_step(block(2)) == pytest.approx(1e-3)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "[[-1.0, {}]]", '[[1.0, {"step": "a"}]]', '[["x", {"step": 1}]]'])
def test_a_damaged_memory_is_none(tmp_path, text):
    paces = taught(tmp_path, [block(2)], [1e-3])
    next(tmp_path.glob("*.json")).write_text(text)
    assert paces.seconds_of_a_step(block(2)) is None
    paces.learn(block(2), 1000, 2.0)
    assert paces.seconds_of_a_step(block(2)) == pytest.approx(2e-3)


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path):
    (tmp_path / "file").write_text("")
    paces = Paces(tmp_path / "file" / "paces")
    paces.learn(block(2), 1000, 1.0)
    assert paces.seconds_of_a_step(block(2)) is None


def test_what_takes_time_is_counted_by_kind():
    counts = counts_of(block(2))
    assert counts[STEP] == 1.0
    assert counts["material-points neo-hookean trilinear 3-D"] == 64.0


@pytest.mark.parametrize(
    ("each", "words"),
    [
        (None, "time: bodies of these kinds have not run on this machine yet; a run tells it after its first second"),
        (0.01, "time: about 2.0 s on this machine, beside set-up, compilation and report"),
    ],
)
def test_steps_and_time_are_said_in_two_lines(each, words):
    steps, time = lines(block(2), Foretold(5e-3, 200, "body `block` (wave): waves"), each)
    assert steps == "steps: about 200 of 0.005 s, bounded by body `block` (wave): waves"
    assert time == words


def test_what_was_not_known_is_told_after_a_second(monkeypatch):
    class Notes:
        def __init__(self):
            self.texts = []

        def begin(self, phase, total=None): ...
        def update(self, **where): ...
        def note(self, text):
            self.texts.append(text)

    notes, now = Notes(), [0.0]
    monkeypatch.setattr("pellucid.results.forecast.on_the_way.monotonic", lambda: now[0])
    progress = ToldOnTheWay(notes)
    progress.begin("running", 10.0)
    for step in range(12):
        now[0] = 0.2 * step
        progress.update(step=step, time=0.1 * step, dt=0.1, points=1, energy_error=0.0)
    assert notes.texts == ["time: about 19.0 s more, at the pace of the first 5 steps"]
