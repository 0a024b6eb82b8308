"""Probes: fields to numbers, points that are followed, reactions."""

import json

import numpy as np
import pytest
from registries import forgotten_afterwards

from pellucid.case import Probe
from pellucid.case.probe import quantity, reduction
from pellucid.errors import RunStopped
from pellucid.results.storage.probes import ProbeReader, reduce

FRAME = {
    "id": np.array([2, 0, 1]),
    "position": np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
    "velocity": np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 1.0], [0.0, -2.0, 0.0]]),
    "pressure": np.array([1.0, 5.0, 3.0]),
    "stress": np.array([[7.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 2.0], [4.0, 4.0, 4.0, 0.0, 0.0, 0.0]]),
}


def probe(quantity, reduce="mean", component=None, **more):
    return Probe(name=f"{quantity}-{reduce}", body="gas", quantity=quantity, reduce=reduce, component=component, **more)


@pytest.mark.parametrize(
    ("asked", "value"),
    [
        (probe("pressure"), 3.0),
        (probe("pressure", "max"), 5.0),
        (probe("pressure", "min"), 1.0),
        (probe("pressure", "sum"), 9.0),
        (probe("pressure", "nearest", at=(1.4, 0.3, 0.0)), 5.0),
        (probe("velocity", "min", "y"), -2.0),
        (probe("velocity", "max"), 5.0),
        (probe("stress", "max", "xy"), 2.0),
        (probe("stress", "max"), 7.0),
        (probe("stress", "nearest", at=(1.0, 0.0, 0.0)), 2.0 * np.sqrt(3.0)),
        (probe("stress", "min"), 0.0),
    ],
)
def test_reduces_a_field_to_a_number(asked, value):
    assert reduce(asked, FRAME.__getitem__) == pytest.approx(value, rel=1e-15)


def test_the_nearest_point_may_be_nearest_across_a_seam():
    field = {"position": np.array([(0.5, 0.0, 0.0), (7.9, 0.0, 0.0)]), "pressure": np.array([1.0, 2.0]), "id": np.arange(2)}
    asked = probe("pressure", "nearest", at=(0.1, 0.0, 0.0))
    assert reduce(asked, field.__getitem__) == 1.0
    assert reduce(asked, field.__getitem__, (2.0, 0.0, 0.0)) == 2.0


class Body:
    name = "gas"

    def __init__(self):
        self.fetched = []
        self.fields = dict(FRAME)

    def stored_field(self, name):
        self.fetched.append(name)
        return self.fields[name]

    def field(self, name):
        return self.stored_field(name)[np.argsort(self.fields["id"])]


def test_only_the_needed_arrays_are_fetched_each_once():
    body = Body()
    asked = [probe("pressure"), probe("velocity", "max"), probe("pressure", "min")]
    assert ProbeReader(asked).read([body], {}, 0.0) == [3.0, 5.0, 1.0]
    assert body.fetched == ["pressure", "velocity"]


def test_counts_the_points_above_a_value():
    asked = [probe("pressure", "count", above=above) for above in (0.0, 1.0, 5.0)]
    assert ProbeReader(asked).read([Body()], {}, 0.0) == [3.0, 2.0, 0.0]


def test_points_at_no_place_are_not_the_nearest():
    """Where a run stopped itself, positions may be no numbers any more."""
    body, nowhere = Body(), np.full(3, np.nan)
    asked = [probe("pressure", reduce, at=(0.0, 0.0, 0.0)) for reduce in ("nearest", "point")]
    for positions, value in (([nowhere, (1.0, 0.0, 0.0), nowhere], 5.0), ([nowhere] * 3, 5.0)):  # that of the lowest number
        body.fields["position"] = np.array(positions)
        reader = ProbeReader(asked)
        reader.start([body])
        assert reader.read([body], {}, 0.0) == [value, value]


def test_follows_the_point_that_was_nearest_at_the_start():
    """Though the points are sorted anew, and though another comes nearer."""
    body = Body()
    reader = ProbeReader([probe("position", "point", "x", at=(0.9, 0.0, 0.0), change=True), probe("pressure", change=True)])
    reader.start([body])
    assert reader.read([body], {}, 0.0) == [0.0, 0.0]
    order = [2, 0, 1]
    body.fields = {name: values[order] for name, values in body.fields.items()}
    body.fields["position"] = body.fields["position"] + np.where(body.fields["id"] == 0, 0.5, -1.0)[:, None]
    body.fields["pressure"] = body.fields["pressure"] + 2.0
    again = ProbeReader(reader._probes, json.loads(json.dumps(reader.to_data())))  # as a checkpoint keeps it
    assert again.read([body], {}, 1.0) == [0.5, 2.0]


def test_carries_a_place_where_no_point_lies():
    body = Body()
    where = probe("position", "point", "x", at=(1.1, 0.2, 0.0), carried=True)
    reader = ProbeReader([where, where.model_copy(update={"name": "way", "change": True})])
    reader.start([body])
    assert reader.read([body], {}, 0.0) == pytest.approx([1.1, 0.0], rel=1e-15)
    body.fields["position"] = body.fields["position"] + np.where(body.fields["id"] == 0, -0.5, 0.25)[:, None]
    assert reader.read([body], {}, 1.0) == pytest.approx([0.6, -0.5], rel=1e-15)


def test_carries_the_corner_of_a_rigid_body_by_its_rotation():
    """The point nearest to the corner moves otherwise than the corner: a quarter of a turn about the middle."""
    body = Body()
    start = np.array([(0.25, 0.25, 0.0), (0.75, 0.25, 0.0), (0.25, 0.75, 0.0), (0.75, 0.75, 0.0)])
    turned = np.stack([0.5 - (start[:, 1] - 0.5), 0.5 + (start[:, 0] - 0.5), start[:, 2]], axis=1)
    body.fields |= {"position": start, "id": np.arange(4)}
    body.arrays = {"start": start, "position": turned, "angle": np.zeros((4, 3))}
    corner = probe("position", "point", "x", at=(1.0, 0.0, 0.0), carried=True)
    reader = ProbeReader([corner, corner.model_copy(update={"name": "way", "component": "y", "change": True})])
    reader.start([body])
    assert reader.read([body], {}, 0.0) == pytest.approx([1.0, 1.0], abs=1e-14)


def test_a_reaction_is_the_mean_force_since_the_row_before():
    asked = [
        Probe(name="r", quantity="reaction", condition="tip", component="y"),
        Probe(name="s", quantity="reaction", condition="tip"),
    ]
    reader = ProbeReader(asked)
    assert reader.units() == {"r": "N", "s": "N"}
    assert reader.read([], {}, 0.0) == [0.0, 0.0]
    assert reader.read([], {"tip": np.array([3.0, 4.0, 0.0])}, 0.5) == [8.0, 10.0]
    again = ProbeReader(asked, json.loads(json.dumps(reader.to_data())))
    assert again.read([], {"tip": np.array([3.0, 3.0, 0.0])}, 0.75) == [-4.0, 4.0]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"quantity": "reaction", "body": "gas"}, "`condition` is required for"),
        ({"quantity": "pressure"}, "requires a `body`"),
        ({"quantity": "pressure", "body": "gas", "reduce": "point"}, "add or remove it"),
        ({"quantity": "pressure", "body": "gas", "condition": "tip"}, "`condition` is required for"),
        ({"quantity": "position", "body": "gas", "component": "z", "carried": True}, "`carried` is allowed only for"),
        (
            {"quantity": "position", "body": "gas", "reduce": "point", "at": (0, 0, 0), "carried": True},
            "requires a `component`",
        ),
    ],
)
def test_probes_that_make_no_sense(table, words):
    with pytest.raises(ValueError, match=words):
        Probe(name="p", **table)


def test_what_users_register_is_read_like_any_other():
    with forgotten_afterwards():

        @reduction("spread")
        def spread(values):
            return values.max() - values.min()

        @quantity("momentum_density", unit="kg/(m^2 s)", meaning="momentum of unit volume", components=3)
        def momentum_density(field):
            return 2.0 * field("velocity")

        @quantity("short", unit="m", meaning="too few")
        def short(field):
            return field("pressure")[:2]

        body = Body()
        asked = [probe("pressure", "spread"), probe("momentum_density", "max", "y"), probe("momentum_density", "spread")]
        reader = ProbeReader(asked)
        assert reader.read([body], {}, 0.0) == [4.0, 8.0, 8.0]
        assert list(reader.units().values()) == ["Pa", "kg/(m^2 s)", "kg/(m^2 s)"]
        with pytest.raises(
            RunStopped, match=r'the quantity "short" of body gas returns an array of shape \(2,\); .* of shape \(3,\)'
        ):
            ProbeReader([probe("short")]).read([body], {}, 0.0)


def test_users_see_points_by_their_numbers_and_the_package_as_they_are_stored():
    with forgotten_afterwards():

        @reduction("first")
        def first(values):
            return values[0]

        @quantity("number", unit="", meaning="number of a point")
        def number(field):
            return field("id")

        asked = [probe("pressure", "first"), probe("number", "first"), probe("number", "max"), probe("pressure", "mean")]
        assert ProbeReader(asked).read([Body()], {}, 0.0) == [5.0, 0.0, 2.0, 3.0]
        assert [one.runs_users_code for one in asked] == [True, True, True, False]
    assert not probe("angular_velocity", "max", "z").runs_users_code


@pytest.mark.parametrize("name", ["mean", "nearest", "pressure"])
def test_names_that_are_taken_are_refused(name):
    with (
        forgotten_afterwards(),
        pytest.raises(ValueError, match=f'"{name}" (is already registered by|is reserved|has the name)'),
    ):
        quantity(name, unit="m", meaning="") if name == "pressure" else reduction(name)(lambda values: 0.0)
