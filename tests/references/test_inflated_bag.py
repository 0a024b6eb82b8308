"""The table of inflated bags."""

import pytest

from pellucid.references.membranes import PAPER_BAG, bag_at_rest


def test_a_bag_under_more_pressure_is_larger():
    soft, stiff = bag_at_rest(0.1), bag_at_rest(0.01)
    assert set(soft) == {"volume", "height", "half_width", "corner"}
    assert all(soft[name] > stiff[name] for name in soft)


def test_the_stiff_bag_is_that_of_paper_but_for_its_dome():
    # the dome of a tenth makes the sheets 0.7 % larger, so the volume 1 to 2 %; stretch at 0.01 adds less than 1 %
    assert bag_at_rest(0.01)["volume"] == pytest.approx(PAPER_BAG, rel=0.02)


def test_is_linear_between_rows():
    assert bag_at_rest(0.035)["volume"] == pytest.approx(0.5 * (bag_at_rest(0.03)["volume"] + bag_at_rest(0.04)["volume"]))


@pytest.mark.parametrize("pressure", [0.0, 0.009, 0.11])
def test_says_where_the_table_ends(pressure):
    with pytest.raises(ValueError, match=r"0\.01/m and 0\.1/m"):
        bag_at_rest(pressure)
