"""What the case of the constriction is judged by: vesicles that are stuck, pressed to a wall, or go with the flow."""

from math import acos, pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.case import load
from pellucid.gallery.benet2015.vesicles_in_flows import CONSTRICTION_METRICS, _room, constriction_metrics

TIMES = np.linspace(0.0, 6.0, 61)
START, ROOM = -4.0, 16.0 - (4.0 * acos(0.375) - 0.75 * sqrt(4.0 - 0.75**2))  # of the channel less half of both segments


def run(speed, aside=0.0, small=0.5):
    """A film whose middle goes at `speed` times the mean flow, `small` m in radius in the throat, `aside` m from the middle."""
    angle = 2.0 * pi * np.arange(96) / 96
    ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)

    def fields(name, time=6.0):
        if name == "piston":
            return {"position": np.array([[time, 0.0, 0.0]])}
        middle = START + speed * 4.0 * time * -START / ROOM
        radius = small if abs(middle) < 2.0 else 1.0
        return {"position": radius * ring + [middle, aside, 0.0], "mass": np.ones(96)}

    case = load("benet2015/vesicle-in-constriction")
    return SimpleNamespace(case=case, fields=fields, times=lambda name: TIMES, triangles=lambda name: np.zeros((0, 3), int))


def failed(of):
    return {name for name, metric in constriction_metrics(of).items() if not metric.passed} - {"area"}


def test_the_room_between_start_and_throat_is_that_of_the_channel():
    assert _room(run(1.0), START, 0.0) == pytest.approx(ROOM, rel=1e-5)


def test_a_vesicle_that_goes_with_the_flow_passes():
    assert set(constriction_metrics(run(1.25))) == set(CONSTRICTION_METRICS)
    assert failed(run(1.25)) == set()


@pytest.mark.parametrize(
    ("of", "what"),
    [
        (run(0.2), {"passage", "beyond"}),  # stuck before the throat
        (run(0.95), {"passage"}),  # the flow leaks past it, or through it
        (run(1.7), {"passage"}),  # faster than the fluid
        (run(1.25, small=0.7), {"clearance"}),
        (run(1.25, aside=0.02), {"sideways"}),
    ],
)
def test_what_is_wrong_fails(of, what):
    assert failed(of) == what
