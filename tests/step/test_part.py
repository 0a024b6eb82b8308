"""The parts of a step: order of the stages, and what a part declares."""

from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from small_cases import GAS, SLIP, box, case

from pellucid.energy import Totals
from pellucid.simulation.simulation import Simulation
from pellucid.state import FIELDS, Field
from pellucid.step.limit import NO_LIMIT
from pellucid.step.part import STAGES, AddedStiffness, StepPart, StepParts

ORDERS = {
    "musl": STAGES,
    "usl": tuple(stage for stage in STAGES if stage != "correct_strain_velocities"),
    "usf": (
        *("begin", "clear_nodes", "exert_forces", "find_contact", "correct_strain_velocities", "before_forces"),
        "before_momentum",
        *("act_on_nodes", "stop_approach", "after_momentum", "before_stress", "check", "end", "balance", "leave", "enter"),
    ),
}


class Listening(StepPart):
    """A part that writes down the stages at which it is called."""

    def __init__(self) -> None:
        self.called: list[str] = []


def _note(stage):
    def note(self, *arguments):
        self.called.append(stage)
        return ()

    return note


for each in STAGES:
    setattr(Listening, each, _note(each))


@pytest.mark.parametrize("scheme", ORDERS)
def test_a_step_calls_the_stages_in_their_order(scheme: str) -> None:
    gas = box((1, 1, 1), (3, 3, 3), GAS)
    sim = Simulation(case(gas, support=SLIP, scheme=scheme, step=1e-3))
    listening = Listening()
    sim.parts.add([listening])
    sim.step()
    assert tuple(listening.called) == ORDERS[scheme]


def test_every_stage_is_a_method_that_does_nothing_by_itself() -> None:
    assert all(callable(getattr(StepPart, stage)) for stage in STAGES)
    parts = StepParts([StepPart()])
    assert all(len(parts.at(stage)) == 0 for stage in STAGES)
    assert (parts.works(), parts.impulses(), parts.facts(), parts.at_stake()) == ([], {}, {}, 0.0)


def test_impulses_and_facts_of_the_same_name_are_joined() -> None:
    class One(StepPart):
        def impulses(self) -> dict[str, np.ndarray]:
            return {"pull": np.ones(3)}

        def facts(self) -> dict[str, dict[str, int]]:
            return {"solver": {type(self).__name__: 1}}

    class Other(One):
        pass

    parts = StepParts([One(), Other()])
    assert parts.impulses()["pull"].tolist() == [2.0, 2.0, 2.0]
    assert parts.facts() == {"solver": {"One": 1, "Other": 1}}


def test_stiffnesses_of_parts_add_to_those_of_bodies_and_limit_the_step_if_they_exceed_them() -> None:
    soft, stiff = Totals(), Totals()

    class Spring(StepPart):
        def added_stiffness(self) -> AddedStiffness:
            return AddedStiffness([soft, stiff], 4.0, "spring", "the bodies oscillate on a spring")

    parts = StepParts([Spring(), StepPart()])
    for stage in (parts.try_out, lambda: parts.end(0.1)):
        soft.rate, stiff.rate = 3.0, 12.0
        stage()
        assert [soft.rate, stiff.rate] == pytest.approx([5.0, 160.0**0.5])
        assert parts.step_limit() == NO_LIMIT, "the rate of one of the bodies is larger"
        soft.rate, stiff.rate = 3.0, 0.0
        stage()
        assert [soft.rate, stiff.rate] == [5.0, 4.0]
        assert parts.step_limit() == (0.2, "spring", "the bodies oscillate on a spring, which limits the step to 0.2 s")


def test_state_is_kept_by_the_place_of_a_part() -> None:
    class Counting(StepPart):
        def __init__(self, count: int) -> None:
            self.count, self.table = count, np.full(2, float(count))

        def state_numbers(self) -> dict[str, int]:
            return {"count": self.count}

        def state_arrays(self) -> dict[str, np.ndarray]:
            return {"table": self.table}

        def restore(self, numbers: dict[str, int]) -> None:
            self.count = numbers["count"]

        def restore_arrays(self, arrays: dict[str, np.ndarray]) -> None:
            self.table = arrays["table"]

    parts, again = StepParts([Counting(1), StepPart(), Counting(2)]), StepParts([Counting(0), StepPart(), Counting(0)])
    again.restore(parts.state_numbers(), parts.state_arrays())
    assert [part.count for part in again.of(Counting)] == [1, 2]
    assert [part.table.tolist() for part in again.of(Counting)] == [[1.0, 1.0], [2.0, 2.0]]


def test_the_order_is_the_one_that_the_page_of_the_parts_states() -> None:
    """The methods of `StepPart` stand in the order of `STAGES`."""
    text = Path(__file__).parents[2].joinpath("src/pellucid/step/part.py").read_text(encoding="utf-8")
    places = [text.index(f"    def {stage}(") for stage in STAGES]
    assert places == sorted(places)


def test_a_part_declares_its_point_arrays_once() -> None:
    dye = Field(1, "kg/m^3", "concentration of a dye, of a test", leaves=True)
    try:

        class Dyes(StepPart):
            point_fields = MappingProxyType({"dye of a test": dye})

        assert FIELDS["dye of a test"] == dye
        with pytest.raises(TypeError, match=r"Paints\.dye of a test: a field of this name exists"):

            class Paints(StepPart):
                point_fields = MappingProxyType({"dye of a test": dye._replace(unit="1")})

    finally:
        FIELDS.pop("dye of a test")
