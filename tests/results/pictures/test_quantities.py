import numpy as np
import pytest

from pellucid.results.pictures.quantities import Look, limits, limits_of, values_of, word_of
from pellucid.results.pictures.style import DIVERGING, SEQUENTIAL
from pellucid.results.storage.run_folder import StoredBody


def test_a_few_extreme_values_do_not_wash_out_the_rest():
    low, high, extend = limits([np.linspace(-1.0, 1.0, 1000), np.array([1e6])])
    assert (low, high) == pytest.approx((-1.0, 1.0), abs=0.02)
    assert extend == "both"


@pytest.mark.parametrize("speeds", [np.zeros(5), np.full(5, 3.0), np.array([np.nan]), np.append(np.zeros(999), 7.0)])
def test_speeds_have_no_colours_below_zero(speeds):
    low, high, extend = limits([speeds])
    assert 0.0 == low < high
    assert extend in ("neither", "max")


@pytest.mark.parametrize(
    ("least", "most", "ends"), [(-3.0, 10.0, (-10.0, 10.0)), (-10.0, 3.0, (-10.0, 10.0)), (-1.0, 10.0, None)]
)
def test_where_both_signs_are_large_zero_has_a_colour_of_its_own(least, most, ends):
    found = limits([np.repeat([least, most], 50)])
    assert found[:2] == (ends or (least, most))
    assert found.palette == (DIVERGING if ends else SEQUENTIAL)


@pytest.mark.parametrize("few", [[-2.0, 1.0], [-2.0], [-2.0, 2.0]])
def test_a_few_values_among_zeros_have_limits(few):
    found = limits([np.append(np.zeros(1000), few)])
    assert found.low < found.high
    assert found.low <= 0.0 <= found.high


def test_one_negative_value_lies_between_the_limits():
    low, high, extend = limits([np.full(5, -2.0)])
    assert low < -2.0 < high < 0.0
    assert extend == "neither"


def test_the_ends_say_whether_values_go_on():
    values = np.linspace(0.0, 1.0, 1001)
    assert limits([np.append(values, np.zeros(20))]).extend == "max"
    assert limits([np.array([1.0, 2.0])]).extend == "both"


def test_a_body_with_an_equation_of_state_shows_its_pressure_any_other_its_equivalent_stress():
    """Also a viscoelastic solid, which stores internal energy as a fluid does."""
    fields = {"internal_energy": np.ones(2), "pressure": np.full(2, 7.0), "stress": np.array([[3.0, 0, 0, 0, 0, 0]] * 2)}
    fluid = StoredBody("water", "material-points", "fluid", "tait", 1000.0)
    solid = StoredBody("block", "material-points", "kelvin-voigt", "", 1000.0)
    start = np.zeros((2, 3))
    assert values_of(fluid, fields, Look("load"), start).tolist() == [7.0, 7.0]
    assert values_of(solid, fields, Look("load"), start).tolist() == [3.0, 3.0]
    assert word_of([solid], Look("load")) == "von Mises stress [Pa]"
    assert word_of([fluid, solid], Look("load")) == "pressure or von Mises stress [Pa]"


def test_displacements_count_from_the_first_positions():
    fields = {"position": np.array([[1.0, 2.0, 3.0], [4.0, 4.0, 0.0]])}
    start = np.array([[1.0, 2.0, 2.5], [1.0, 0.0, 0.0]])
    solid = StoredBody("block", "meshless-solid", "neo-hookean", "", 1000.0)
    assert values_of(solid, fields, Look("displacement"), start).tolist() == [0.5, 5.0]
    assert word_of([solid], Look("displacement", unit="mm")) == "displacement [mm]"


def test_a_field_has_the_unit_and_the_component_that_are_asked_for():
    solid = StoredBody("block", "meshless-solid", "neo-hookean", "", 1000.0)
    fields = {"stress": np.array([[3e3, -2e3, 0, 0, 0, 0]] * 2)}
    start = np.zeros((2, 3))
    assert values_of(solid, fields, Look("stress", "yy", "kPa"), start).tolist() == [-2.0, -2.0]
    assert word_of([solid], Look("stress", "yy", "kPa")) == "stress yy [kPa]"
    assert np.isnan(values_of(solid, fields, Look("damage"), start)).all(), "it has no such field"


def test_limits_that_are_asked_for_say_whether_values_go_on():
    assert limits_of([np.array([0.0, 5.0, np.nan])], Look("speed", limits=(1.0, 6.0))) == (1.0, 6.0, "min")
