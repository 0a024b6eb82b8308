"""Flows without a way out, vents that never open and faces that absorb nothing are warned of."""

import bags
import pytest
from small_cases import GAS, SLIP, box, case

from pellucid.case import Case
from pellucid.set_up.first_look import look
from pellucid.set_up.flows import flow_warnings

WATER = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 20.0}}
SIDES = [support for support in SLIP if support["where"] != "x-lower"]
OUT = {"where": ["x-upper"]}


def tank(inflow=None, material=WATER, length=10.0, support=SIDES, outflow=(), absorbing=(), others=(), end=1.0):
    """A fluid in a duct of 10 x 3 x 1 m, into which 3 m³/s come."""
    fluid = box((0, 0, 0), (length, 3, 1), material, name="fluid")
    tables = case(fluid, *others, counts=(10, 3, 1), support=support, absorbing=absorbing, end=end).to_data()
    tables["inflow"] = [{"where": "x-lower", "body": "fluid"} | (inflow or {"velocity": 1.0})]
    return Case.model_validate(tables | {"outflow": list(outflow)})


@pytest.mark.parametrize(
    "inflow",
    [{"velocity": 1.0}, {"flow_rate": 3.0}, {"velocity": 1.0, "amplitude": {"times": [0, 1], "shares": [1, 1]}}],
)
def test_a_liquid_that_comes_in_and_cannot_leave(inflow):
    (text,) = [text for text in look(tank(inflow)) if "can leave" in text]
    for words in ("inflow number 1 adds 3 m³ of body fluid until time.end", "0 m³ of the grid are empty"):
        assert words in text
    assert "compressed from 0.2 s on" in text  # 2 % of 30 m³
    assert "by an [[outflow]]" in text


def test_it_may_fill_what_is_empty():
    assert list(flow_warnings(tank(length=6.0, end=4.0))) == []
    (text,) = flow_warnings(tank(length=6.0, end=5.0))
    assert "adds 15 m³" in text
    assert "12 m³ of the grid are empty" in text
    assert "compressed from 4.1 s on" in text


@pytest.mark.parametrize(
    "options",
    [
        {"material": GAS},
        {"inflow": {"pressure": 100.0}},
        {"outflow": [OUT], "support": [one for one in SIDES if one["where"] != "x-upper"]},
        {"support": [one for one in SIDES if one["where"] != "y-upper"]},
        {"length": 5.0, "end": 5.0, "others": [box((5, 0, 0), (10, 3, 1), GAS, name="air")]},
        {"end": 0.1},
    ],
    ids=["gas", "pressure", "outflow", "open", "cushion", "short"],
)
def test_others_have_a_way_out(options):
    assert list(flow_warnings(tank(**options))) == []


OPEN = {"outflow": [OUT], "support": [one for one in SIDES if one["where"] != "x-upper"]}


def test_a_face_at_which_an_inflow_gives_the_velocity_absorbs_nothing():
    absorbing = [{"body": "fluid", "where": ["x-lower", "x-upper"]}]
    (text,) = flow_warnings(tank(absorbing=absorbing, **OPEN))
    assert text.startswith("absorbing number 1 has no effect at the face x-lower: inflow number 1 prescribes the velocity")
    assert list(flow_warnings(tank(absorbing=[absorbing[0] | {"where": ["x-upper"]}], **OPEN))) == []
    assert list(flow_warnings(tank({"pressure": 1.0}, absorbing=absorbing, **OPEN))) == []


FED = {"times": [0.0, 0.1], "mass_flows": [2.0, 2.0], "temperatures": [300.0, 300.0]}


@pytest.mark.parametrize(
    ("opens_at", "inflator", "most"),
    [
        (2500.0, None, "2000 Pa"),
        (1e6, FED, " Pa, including the gas of the inflator"),
        (1500.0, None, None),
        (0.0, None, None),
    ],
)
def test_a_vent_that_never_opens(opens_at, inflator, most):
    more = {} if inflator is None else {"inflator": inflator}
    texts = list(flow_warnings(bags.case({"gas": bags.AIR, "vent": [{"area": 0.1, "opens_at": opens_at}], **more})))
    assert len(texts) == (most is not None)
    if most:
        assert texts[0].startswith(f"vent number 1 of enclosed `bag` never opens: opens_at = {opens_at:g} Pa above")
        assert most in texts[0]


def test_the_pressure_with_an_inflator_is_that_of_all_the_gas_in_the_volume_at_the_start():
    """(γ - 1) times the energy at the start and the enthalpy that comes in, over the volume."""
    made = bags.case({"gas": bags.AIR, "vent": [{"area": 0.1, "opens_at": 1e6}], "inflator": FED})
    volume = made.body[0].occupied().measure((True, True, True))
    most = 2000.0 + 1.4 * 287.05 * 300.0 * 0.2 / volume
    (text,) = flow_warnings(made)
    assert f"at most {most:.4g} Pa, including" in text
    assert (
        list(flow_warnings(bags.case({"gas": bags.AIR, "vent": [{"area": 0.1, "opens_at": 0.99 * most}], "inflator": FED})))
        == []
    )


def test_what_may_be_squeezed_is_not_judged():
    vent = {"gas": bags.AIR, "vent": [{"area": 0.1, "opens_at": 1e5}]}
    assert list(flow_warnings(bags.case(vent, gravity=(0, 0, -9.81)))) == []
    assert list(flow_warnings(bags.case(vent, bodies=[bags.skin(velocity=(1, 0, 0))]))) == []
    assert list(flow_warnings(bags.case(vent, bodies=[bags.skin(inflation=0.1)]))) == []
