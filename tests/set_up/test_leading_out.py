"""What is told of supports that move a face of the grid out of it, in `validate` and where a point passes the face."""

import pytest
from small_cases import advance, box, case, simulation

from pellucid.errors import RunStopped
from pellucid.set_up.first_look import look
from pellucid.set_up.leading_out import leading_out

FLUID = {"kind": "fluid", "density": 1.0, "viscosity": 0.01, "eos": {"kind": "tait", "sound_speed": 10.0}}
LID = {"name": "lid", "where": "y-upper", "velocity": (1, 0.5, 0)}
REST = {"where": ["x-lower", "x-upper", "y-lower"]}


def cavity(*support, **more):
    return {"support": support, "counts": (4, 4, 0), "cell": 0.25, "end": 9.0} | more


FILLED = box((0, 0, 0), (1, 1, 0), FLUID, (2, 2, 1))


def test_a_lid_that_moves_out_is_warned_of():
    built = case(FILLED, **cavity(LID, REST))
    (text,) = leading_out(built)
    assert text.startswith("support `lid` moves the face y-upper out of the grid at 0.5 m/s")
    assert "set its velocity along y to 0" in text
    assert text in list(look(built))


@pytest.mark.parametrize(
    "lid",
    [
        {"velocity": (1, 0, 0)},
        {"velocity": (1, -0.5, 0)},
        {"velocity": (1, 0.5, 0), "fix": ["x"]},
        {"where": "x-lower", "velocity": (0.3, 0, 0)},
    ],
    ids=["along", "into", "not-held-across", "piston"],
)
def test_lids_and_pistons_that_stay_or_move_in_are_not(lid):
    assert list(leading_out(case(FILLED, **cavity({"where": "y-upper"} | lid)))) == []


def test_a_point_that_follows_it_names_the_support():
    with pytest.raises(RunStopped, match=r"passed the face y-upper, whose support moves out of the grid at 0.5 m/s; set the"):
        advance(simulation(FILLED, **cavity(LID, REST)), 400)
