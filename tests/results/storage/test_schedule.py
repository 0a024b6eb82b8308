import pytest

from pellucid.results.storage.recorder import Schedule, capacity


def served(interval: float, step: float, steps: int) -> list[int]:
    schedule, found = Schedule(interval), []
    time = 0.0
    for number in range(steps + 1):
        if schedule.due(time):
            schedule.mark(time, number)
            found.append(number)
        time += step
    return found


def test_the_first_step_at_or_after_each_instant():
    assert served(0.1, 0.03, 12) == [0, 4, 7, 10]


def test_sums_of_steps_that_miss_a_multiple_by_rounding_still_reach_it():
    assert served(0.1, 0.1, 30) == list(range(31))
    assert served(2e-5 * 7, 2e-5, 70) == list(range(0, 71, 7))


def test_instants_passed_by_one_step_are_served_once():
    assert served(0.1, 0.25, 3) == [0, 1, 2, 3]


@pytest.mark.parametrize(("end", "interval"), [(1.0, 0.1), (1.0, 0.3), (0.143, 0.0143), (1.0, 5.0)])
def test_no_run_writes_more_than_its_capacity(end, interval):
    step = min(end, interval) / 7.3
    assert len(served(interval, step, int(end / step) + 1)) + 1 <= capacity(end, interval)
