"""Declaration of a pass over points, and its functions of one point."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.grid.folding import Mirrored
from pellucid.grid.lattice import without_images
from pellucid.grid.passes.blocks import cache_lines
from pellucid.grid.passes.gifts import Nothing, example_of, giving
from pellucid.grid.points import InOrder, MappedPoints
from pellucid.jit import default_function, generic, point_function
from pellucid.jit.bundle import Bundle

NO_MAXIMUM = -1


class Found(NamedTuple):
    """Result of a pass (a loop over points) at one point: output, contributions to sums, value for a maximum, and fault
    code."""

    kept: Any  # output of the point, a value for each array of `kept`
    sums: Any  # contributions to the sums, in the order of `Declaration.sums`
    largest: float  # value for the maximum over the points, which is at least 0
    fault: float  # code of `pellucid.grid.points`, OK if none; an INVERTED point keeps its old values


@generic
def looked_up(rule: Any, lattice: Any, functions: Any, about: Any, p: Any) -> Any:
    """Return values of a point that a pass (a loop over points) needs before it gathers nodal values, e.g. from a table;
    branches are allowed.

    rule: `Declaration.rule`; functions: shape functions along x, y, z; about: the stencil of the point; p: its input
    values.
    """


@generic
def gathered(rule: Any, about: Any, lattice: Any, nodes: Any, p: Any, known: Any) -> Any:
    """Return values gathered from the nodes of a point.

    rule: `Declaration.rule`; about: the stencil of the point; nodes: nodal arrays; p: input values of the point; known:
    result of `looked_up`. Evaluated for numbers, or for vectors of several points with the same nodes. Use only + - * / and
    the sums of `pellucid.grid.stencil`, no branches.
    """


@generic
def at_point(task: Any, lattice: Any, dt: float, p: Any, known: Any, g: Any) -> Any:
    """Return the results of a pass (a loop over points) at one point (`Found`) after a step dt [s].

    task: operation of the pass; p: input values of the point; known: result of `looked_up`; g: result of `gathered`.
    """


@generic
def in_cell(task: Any, p: Any, g: Any) -> Any:
    """Return the number that a point adds to the sums of its grid cell, if the pass (a loop over points) sums over cells;
    arguments as in `at_point`."""


@default_function(looked_up)
def _nothing_known(rule, lattice, functions, about, p):
    return ()


@default_function(gathered)
def _nothing_gathered(rule, about, lattice, nodes, p, known):
    return ()


@generic
def gathered_about(folding: Any, rule: Any, about: Any, lattice: Any, nodes: Any, p: Any, known: Any) -> Any:
    """Return the result of `gathered`; folding: that of the lattice, whose type selects an implementation."""


@default_function(gathered_about)
def _gathered_within(folding, rule, about, lattice, nodes, p, known):
    return gathered(rule, about, lattice, nodes, p, known)


@point_function(gathered_about, Mirrored)
def _gathered_beside_plane(folding, rule, about, lattice, nodes, p, known):
    if folding.reaches[uintp(about.start + folding.shift)]:
        return gathered(rule, about, lattice, nodes, p, known)
    return gathered(rule, about, without_images(lattice), nodes, p, known)


class Declaration(NamedTuple):
    """Options of a pass (a loop over points) for the function that executes it, in addition to input and output.

    Values of points are numbers and tuples of numbers; examples define their types.
    """

    gathers: Any = ()  # example of the gathered values
    looks_up: Any = ()  # example of the looked-up values
    rule: Any = None  # first argument of `looked_up` and `gathered`; None: the task of the pass
    rule_reads: Any = None  # example of the first part of the input, which these two receive; None: all of it
    sums: tuple[int, ...] = ()  # columns of `Slabs.sums` that the pass fills
    largest: int = NO_MAXIMUM  # column for a maximum over the points
    places: bool = False  # True if the first output is the new position, which is then checked


class PointRows(NamedTuple):
    """Arrays from which the input of a pass (a loop over points) is read, or to which its output is written, and the order
    of the points in them."""

    index: Any  # `InOrder` or `ByIndex`
    like: Any  # example of the values of one point
    arrays: Any  # (nested tuples of) arrays of all points


class Gathering(NamedTuple):
    """Data of the part of a pass (a loop over points) that gathers values from the grid nodes. They do not depend on the
    material law of the pass."""

    rule: Any  # first argument of `looked_up` and `gathered`
    functions: Any  # shape functions along x, y, z
    lattice: Any  # `Lattice`
    nodes: Any  # nodal arrays, `Nodes`
    read_like: Any  # example of the input values of one point that `looked_up` and `gathered` read
    known_like: Any  # example of the values of `looked_up`
    gathered_like: Any  # example of the values of `gathered`
    lines: np.ndarray  # `cache_lines` of the input arrays; none if the points are not in order


class Evaluation(NamedTuple):
    """Data of the part of a pass (a loop over points) that evaluates `at_point`, the physics of a point. They do not depend
    on the shape functions."""

    task: Any  # operation of the pass, first argument of `at_point`
    lattice: Any  # `Lattice`
    read_like: Any  # example of the input values of one point
    known_like: Any  # example of the values of `looked_up`
    gathered_like: Any  # example of the values of `gathered`
    found_like: Any  # example of `Found`


class Accounting(NamedTuple):
    """Data for the sums and faults of a pass (a loop over points). They depend neither on the material law nor on the shape
    functions."""

    lattice: Any  # `Lattice`
    index: Any  # `InOrder` or `ByIndex`
    slabs: Bundle  # of `Slabs`


class PassPoints(NamedTuple):
    """A pass (a loop over points) and the points of a body, as arguments of `each_point`. Each part is a bundle, for a
    kernel that other passes share."""

    read: Bundle  # of `PointRows`: arrays of the input
    gathering: Bundle  # of `Gathering`
    evaluation: Bundle  # of `Evaluation`
    accounting: Bundle  # of `Accounting`
    kept: Bundle  # of `PointRows`: arrays of the output
    giving: Bundle  # of `GivingPoints`: contribution to the nodes after the pass, see `gifts`
    to_cells: Any  # `NotToCells` or `ToCells`
    sums: np.ndarray  # columns of `Slabs.sums`
    largest: int  # column of `Slabs.sums` for a maximum, negative if there is none
    places: int  # 1 if the pass moves the points, else 0
    by_colour: bool  # True if the pass may contribute to nodes or cells; its loop then always runs by colour


def pass_points(
    task: Any, declared: Declaration, mapped: MappedPoints, read: Any, kept: Any, gives: Any = None, to_cells: Any = None
) -> Bundle:
    """Bind a pass to the points of a body, when a simulation is built; the result is executed by `each_point`.

    task: operation at a point; declared: its options. read, kept: input and output, tuples of float64 arrays, shape
    (points,) or (points, components). The first member of `read` is the position of the points; so is the first member of
    `kept` if the pass moves the points. A member may be a NamedTuple of arrays, such as the state of a law, or () if absent.
    gives: contribution to the nodes after the pass, see `gifts`; to_cells: `ToCells` if the pass sums over cells. Raises
    ValueError for arrays that do not fit. mapped: the points.
    """
    if read[0] is not mapped.points.position:
        raise ValueError("the first that a pass reads is the position of the body's points")
    if declared.places and kept[0] is not mapped.points.position:
        raise ValueError("the first that a pass with new places keeps is the position of the body's points")
    for array in arrays_in((*read, *kept)):
        if array.dtype != np.float64 or not array.flags.c_contiguous or len(array) != len(mapped.points.position):
            n = len(mapped.points.position)
            raise ValueError(
                f"a pass takes arrays of doubles in C order with {n} rows, not {array.dtype} of shape {array.shape}"
            )
    read_like, kept_like = example_of(read), example_of(kept)
    found_like = Found(kept_like, (0.0,) * len(declared.sums), 0.0, 0.0)
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    lines = cache_lines(arrays_in(read) if isinstance(index, InOrder) else [])
    rule = task if declared.rule is None else declared.rule
    rule_reads = read_like if declared.rule_reads is None else declared.rule_reads
    gathering = Gathering(rule, functions, lattice, mapped.nodes, rule_reads, declared.looks_up, declared.gathers, lines)
    evaluation = Evaluation(task, lattice, read_like, declared.looks_up, declared.gathers, found_like)
    return Bundle(
        PassPoints(
            Bundle(PointRows(index, read_like, read)),
            Bundle(gathering),
            Bundle(evaluation),
            Bundle(Accounting(lattice, index, Bundle(mapped.slabs))),
            Bundle(PointRows(index, kept_like, kept)),
            giving(mapped, Nothing() if gives is None else gives),
            NotToCells() if to_cells is None else to_cells,
            np.array(declared.sums, np.int64),
            declared.largest,
            int(declared.places),
            gives is not None or to_cells is not None,
        )
    )


class PassAlone(NamedTuple):
    """A pass (a loop over the points of a body) that a benchmark runs alone, to measure its speed."""

    run: Callable[[], None]  # executes the pass once on all points
    traffic: list[np.ndarray]  # point arrays that the pass reads and writes


def traffic_of(points: Bundle) -> list[np.ndarray]:
    """Return the point arrays that a pass (a loop over points, built by `pass_points`) reads and writes."""
    return arrays_in(points.read.arrays) + arrays_in(points.kept.arrays)


def arrays_in(values: Any) -> list[np.ndarray]:
    """Return a list of all arrays in `values`, an array or (nested) tuples of arrays, such as the input or output of a pass
    (a loop over points)."""
    return [array for part in values for array in arrays_in(part)] if isinstance(values, tuple) else [values]


class NotToCells(NamedTuple):
    """Value of `PassPoints.to_cells` for a pass (a loop over points) that sums nothing over grid cells."""


class ToCells(NamedTuple):
    """Value of `PassPoints.to_cells` for a pass (a loop over points) in which each point adds a number, the result of
    `in_cell`, to a sum of the grid cell that contains the point."""

    into: np.ndarray  # (cells, columns) sums of each cell
    column: int  # column of `into` to which the numbers are added
