"""The table of Martin and Moyce, and what the references say of a column."""

import numpy as np
import pytest

from pellucid.case import load
from pellucid.references.flows import Column, martin_moyce


@pytest.mark.parametrize(("quantity", "rows", "first", "last"), [("front", 15, 1.11, 4.11), ("height", 17, 0.94, 0.06)])
def test_tables(quantity, rows, first, last):
    time, value = martin_moyce(quantity)
    assert len(time) == len(value) == rows
    assert (value[0], value[-1]) == (first, last)
    assert np.all(np.diff(time) > 0)
    assert np.all(np.diff(value) * (1 if quantity == "front" else -1) > 0)


def test_the_experiment_is_slower_than_the_bound():
    column = Column.of(load("basics/dam-break"))
    time, front = martin_moyce("front")
    seconds = time / column.front_time(1.0)
    assert np.all(front < column.ritter(seconds))


def test_the_column_is_that_of_the_experiment():
    column = Column.of(load("basics/dam-break"))
    assert column.width == pytest.approx(2.25 * 0.0254)
    assert column.aspect == pytest.approx(2.0)
    # the sheet's front runs at 2 sqrt(gH)
    speed = (column.ritter(0.1) - column.ritter(0.0)) * column.width / 0.1
    assert speed == pytest.approx(2 * np.sqrt(9.81 * 0.1143))
