"""Where rows are cut, and what is handed on there."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.errors import UsageError
from pellucid.ranks.domain import Domain, OfListed, Rows, cuts_of
from pellucid.ranks.group import Group


@pytest.mark.parametrize(
    ("cost", "processes", "expected"),
    [
        ([1, 1, 1, 1], 2, [0, 2, 4]),
        ([9, 1, 1, 1], 2, [0, 1, 4]),
        ([0, 0, 0, 5], 3, [0, 1, 3, 4]),  # each has a row
        ([1, 1], 4, [0, 1, 2, 2, 2]),  # as far as there are so many
        ([0, 0, 0], 2, [0, 1, 3]),
    ],
)
def test_rows_are_shared_by_their_cost(cost, processes, expected):
    assert cuts_of(np.array(cost, float), processes).tolist() == expected


class Beside(Group):
    """The first of two processes, which hears what the second one has."""

    rank, size = 0, 2

    def __init__(self, heard):
        super().__init__()
        self.heard, self.said = heard, []

    def pass_on(self, messages):
        for process, message, sends in messages:
            assert process == 1
            if sends:
                self.said.append(message.copy())
            else:
                message[:] = self.heard.view(np.uint8).reshape(-1)


ROWS = Rows(edges=np.array([0, 3, 6]), across=1, stencil=2, layer=2, nodes=16)
SHARED = slice(4, 10)  # the nodes of layers 2, 3 and 4


def cut(heard):
    domain = Domain()
    domain.group = Beside(heard)
    domain.cut(ROWS, np.ones(2))
    domain.leave()  # not the region of this process
    domain.is_cut = True
    return domain


def test_the_even_row_hands_on_and_takes_the_whole_back():
    nodes, whole = np.zeros((16, 3)), np.full((6, 3), 5.0)

    def give():
        nodes[:8] += 1.0  # what its row reaches

    domain = cut(whole)
    domain.by_parity(lambda: give() if not domain.group.said else None, [nodes])
    (said,) = domain.group.said
    assert np.array_equal(said.view(float).reshape(6, 3), [[1.0] * 3] * 4 + [[0.0] * 3] * 2)
    assert np.array_equal(nodes[SHARED], whole)
    assert np.array_equal(nodes[:4], np.ones((4, 3)))
    assert domain.bytes_sent == whole.nbytes


def test_of_a_list_those_beside_the_cut_are_handed_on():
    node = np.array([1, 3, 4, 9, 10])
    values = np.arange(10.0)  # two for each
    domain = cut(np.array([-4.0, -5.0, -6.0, -7.0]))
    domain.by_parity(lambda: None, [OfListed(values, node)])
    assert values.tolist() == [0.0, 1.0, 2.0, 3.0, -4.0, -5.0, -6.0, -7.0, 8.0, 9.0]


def test_what_lies_near_are_the_rows_beside_too():
    rows = np.array([0, 10, 20, 30, 40])
    domain = Domain()
    assert domain.near(rows) == (0, 40)
    domain.is_cut, domain.first, domain.end = True, 2, 3
    assert domain.near(rows) == (10, 40)


def test_the_launcher_of_another_mpi_is_told_of(monkeypatch):
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    monkeypatch.setitem(sys.modules, "mpi4py", SimpleNamespace(MPI=SimpleNamespace(COMM_WORLD=SimpleNamespace(size=1))))
    with pytest.raises(UsageError, match=r"2 processes were started together, .* another MPI"):
        Group().join()


def test_without_mpi4py_several_processes_are_an_error(monkeypatch):
    monkeypatch.setenv("PMI_SIZE", "2")
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    with pytest.raises(UsageError, match=r"pip.* install '\.\[mpi\]' in the clone"):
        Group().join()
