"""The choice of threads by what steps cost."""

import pytest

from pellucid.simulation.threads import FIRST, HELD, LEAST_HELD, ThreadChoice, numbers_up_to


class Machine:
    """A clock on which a step takes what `cost` says of the threads in use."""

    def __init__(self, cost):
        self.cost, self.now, self.threads, self.used = cost, 0.0, None, []

    def use(self, threads):
        self.threads = threads

    def steps(self, choice, n):
        for _ in range(n):
            choice.before_step()
            self.now += self.cost(self.threads)
            self.used.append(self.threads)
            choice.after_step()
            self.now += 5.0 * self.cost(1)  # what is between steps counts to none of them


def run(cost, most=8, first=1, n=400):
    machine = Machine(cost)
    choice = ThreadChoice(numbers_up_to(most), first, machine.use, lambda: machine.now)
    machine.steps(choice, n)
    return machine, choice


def test_numbers():
    assert numbers_up_to(1) == [1]
    assert numbers_up_to(2) == [1, 2]
    assert numbers_up_to(6) == [1, 2, 4, 6]
    assert numbers_up_to(8) == [1, 2, 4, 8]


@pytest.mark.parametrize("first", [1, 3, 100])
@pytest.mark.parametrize(
    ("cost", "best"),
    [
        (lambda n: 1e-2 / n, 8),
        (lambda n: 1e-2 * n, 1),
        (lambda n: 1e-2 / n + 1e-3 * n, 4),
        (lambda n: 1e-2 * (1.0 - 0.01 * n), 1),
    ],
    ids=["all help", "none helps", "four are best", "hardly any gain"],
)
def test_the_number_that_costs_least_is_found_from_anywhere(cost, best, first):
    _, choice = run(cost, first=first)
    assert choice.chosen == best


def test_what_was_chosen_is_used_but_in_trials():
    machine, choice = run(lambda n: 1e-2 / n, n=2000)
    assert machine.used[:FIRST] == [1] * FIRST
    assert machine.used.count(8) > 0.9 * len(machine.used)
    assert machine.threads == choice.chosen == 8


def test_trials_are_repeated_when_the_machine_changes():
    machine, choice = run(lambda n: 1e-2 / n)
    machine.cost = lambda n: 1e-2 * n
    machine.steps(choice, round((LEAST_HELD + HELD) / 1e-2))
    assert choice.chosen == 1


def test_a_number_that_was_given_stays():
    machine = Machine(lambda n: 1e-2 * n)
    choice = ThreadChoice([4], 1, machine.use, lambda: machine.now)
    machine.steps(choice, 500)
    assert set(machine.used) == {4}
