"""Sorting by nodes, and slabs that threads may share."""

from itertools import pairwise

import numpy as np
import pytest
from small_cases import SLIP, advance, box, case, place, shear_flow, simulation

from pellucid.approximants import GRID_FUNCTIONS, grid_functions
from pellucid.approximants.grid_functions import axis_weights
from pellucid.grid.lattice import Grid
from pellucid.grid.points import VECTORS
from pellucid.grid.sorting import EACH_SORTING, ShortRuns, slabs_of, sort_by_nodes
from pellucid.jit.columns import BLOCK
from pellucid.jit.vector import LANES
from pellucid.simulation.simulation import Simulation

COUNTS = [(4, 4, 4), (1, 1, 40), (60, 2, 1), (1, 9, 3), (200, 1, 1), (3, 17, 2)]


def cloud(counts, n, squeeze=1.0):
    """A grid, and arrays of points on it at random, some exactly on walls and nodes."""
    grid = Grid(case(box((0, 0, 0), counts), counts=counts).grid)
    generator = np.random.default_rng(n)
    position = generator.random((n, 3)) ** squeeze * counts
    on_nodes = generator.random(n) < 0.2
    position[on_nodes] = np.rint(position[on_nodes])
    return grid, {"id": np.arange(n), "position": position, "stress": generator.random((n, 6))}


# lowest place of a point whose first node is the one at the origin, were there no walls; with GIMP the half edge of a point
BEGINS = {"trilinear": 0.0, "gimp": 1.0 / 6.0, "quadratic-bspline": 0.5, "cubic-bspline": 1.0}


def layers_of(grid, position, functions):
    """First node of each point along the axes, shape (n, 3); walls have no nodes beyond them."""
    last = np.array(grid.lattice.counts) - (2 if functions == "cubic-bspline" else 1)
    nodes = np.floor(position / grid.lattice.cell - BEGINS[functions]).astype(int)
    return np.where(grid.thin, 0, np.clip(nodes, 0, last))


def node_of(grid, position, functions="trilinear"):
    """First node of each point, counted in the order of the memory. With trilinear functions it stands for the cell."""
    lattice = grid.lattice
    axes = [lattice.slab_axis, *(axis for axis in range(3) if axis != lattice.slab_axis)]
    nodes = layers_of(grid, position, functions)
    return np.ravel_multi_index(nodes[:, axes].T, [lattice.counts[axis] for axis in axes])


def slab_of(grid, slabs, position, functions):
    """In which slab each point lies, by the layers of its first node along the two axes of the cuts."""
    nodes = layers_of(grid, position, functions)
    a, b = nodes[:, [grid.lattice.slab_axis]], nodes[:, [grid.lattice.cut_axis]]
    low, high, left, right = slabs.layers.T
    within = (a >= low) & (a < high) & (b >= left) & (b < right)
    assert np.all(within.sum(axis=1) == 1), "each place is in one slab"
    return np.argmax(within, axis=1)


def place_in_slabs(grid, slabs, position, functions):
    """What the points are sorted by: slab, then first node along the axis of the slabs, that of the cuts, the third."""
    nodes, main, second = layers_of(grid, position, functions), grid.lattice.slab_axis, grid.lattice.cut_axis
    return [*nodes[:, [3 - main - second, second, main]].T, slab_of(grid, slabs, position, functions)]


NO_MEMORY = np.zeros(0, np.int64)


def sorted_into_slabs(arrays, grid, functions):
    """The slabs among which the points are divided."""
    slabs = slabs_of(grid.lattice, functions)
    sort_by_nodes(arrays, NO_MEMORY, grid.lattice, functions, slabs)
    return slabs


def functions_on(grid, name):
    """Functions along the axes, thin ones among them."""
    return grid_functions(name, (3, 3, 3), grid.thin)


@pytest.mark.parametrize("counts", COUNTS)
@pytest.mark.parametrize("n", [1, 2, 1000])
@pytest.mark.parametrize("functions", GRID_FUNCTIONS)
def test_sorting_is_a_stable_permutation_by_first_nodes(counts, n, functions):
    grid, arrays = cloud(counts, n)
    before = {name: array.copy() for name, array in arrays.items()}
    slabs = sorted_into_slabs(arrays, grid, functions_on(grid, functions))
    order = arrays["id"]
    assert np.array_equal(order, np.lexsort(place_in_slabs(grid, slabs, before["position"], functions)))  # which is stable
    for name, array in arrays.items():
        assert np.array_equal(array, before[name][order]), name
    again = {name: array.copy() for name, array in arrays.items()}
    spare = sort_by_nodes(arrays, NO_MEMORY, grid.lattice, functions_on(grid, functions), slabs)
    assert spare is NO_MEMORY
    for name, array in arrays.items():
        assert np.array_equal(array, again[name]), "sorted points stay as they are"


@pytest.mark.parametrize("counts", COUNTS)
@pytest.mark.parametrize("squeeze", [1.0, 4.0])
@pytest.mark.parametrize("functions", GRID_FUNCTIONS)
def test_slabs_cover_points_and_layers_once(counts, squeeze, functions):
    grid, arrays = cloud(counts, 700, squeeze)
    slabs = sorted_into_slabs(arrays, grid, functions_on(grid, functions))
    assert slabs.first[0] == 0
    assert slabs.first[-1] == 700
    found = slab_of(grid, slabs, arrays["position"], functions)
    assert np.array_equal(found, np.repeat(np.arange(len(slabs.layers)), np.diff(slabs.first)))
    for k, axis in enumerate((grid.lattice.slab_axis, grid.lattice.cut_axis)):
        low, high = slabs.bounds[found, 2 * k : 2 * k + 2].T
        place = arrays["position"][:, axis]
        room = np.minimum(place - low, high - place)
        within = (place >= 1.0) & (place <= counts[axis] - 1.0)  # beyond the walls nothing goes
        assert np.all(room[within] >= (2.0 / 3.0 - 1e-12 if functions == "gimp" else 1.0))
    assert not slabs.left_slab.any()
    assert not slabs.fault.any()


@pytest.mark.parametrize("name", GRID_FUNCTIONS)
@pytest.mark.parametrize("counts", [(n, m, 2) for n in (2, 3, 9, 10, 11, 64, 333) for m in (1, 2, 6, 9, 10)])
def test_slabs_of_one_colour_reach_no_common_node(name, counts):
    """Points may stray a layer beyond their slab before they are sorted again; weights of zero are written too."""
    grid, arrays = cloud(counts, 300)
    functions = functions_on(grid, name)
    slabs = sorted_into_slabs(arrays, grid, functions)
    boxes = np.array([_nodes_reached(grid, functions, bounds) for bounds in slabs.bounds])  # (slabs, 4)
    place = np.stack(np.divmod(np.arange(len(boxes)), slabs.across), axis=1)
    for one in range(len(boxes)):
        same = np.all(place % 2 == place[one] % 2, axis=1)
        same[one] = False
        low, high, left, right = boxes[one]
        meets = (boxes[:, 0] <= high) & (boxes[:, 1] >= low) & (boxes[:, 2] <= right) & (boxes[:, 3] >= left)
        assert not np.any(meets & same)


def _nodes_reached(grid, functions, bounds):
    """From which node to which points within these bounds reach, along both axes of the cuts."""
    reached = []
    for k, axis in enumerate((grid.lattice.slab_axis, grid.lattice.cut_axis)):
        fn, n = functions[axis], grid.lattice.counts[axis]
        ends = [max(bounds[2 * k], 0.0), min(np.nextafter(bounds[2 * k + 1], 0.0), float(n))]
        places = np.clip(np.concatenate([ends, np.linspace(*ends, 97)]), *ends)
        firsts = [axis_weights(fn, float(u), n)[0] for u in places]
        reached += [min(firsts), max(firsts) + fn.stencil - 1]
    return reached


def test_enough_slabs_for_many_threads():
    grid, arrays = cloud((400, 1, 1), 5000)
    for name in GRID_FUNCTIONS:
        copied = {key: array.copy() for key, array in arrays.items()}
        slabs = sorted_into_slabs(copied, grid, functions_on(grid, name))
        shares = np.diff(slabs.first)
        assert len(shares) >= 32
        assert shares.max() < 3.0 * shares.mean()


@pytest.mark.parametrize("functions", GRID_FUNCTIONS)
def test_bodies_of_a_field_have_the_same_slabs(functions):
    """Wherever their points are: joint loops let threads do one slab of all bodies at a time."""
    grid, one = cloud((40, 3, 1), 500)
    _, other = cloud((40, 3, 1), 7, squeeze=4.0)
    layers = [sorted_into_slabs(arrays, grid, functions_on(grid, functions)).layers for arrays in (one, other)]
    assert np.array_equal(*layers)


def test_a_straying_point_triggers_sorting_once():
    sim = simulation(box((0, 0, 0), (3, 1, 1)), counts=(40, 1, 1))
    body = sim.bodies[0]
    first, since = body.storage.slabs.first.copy(), body.storage.short_runs
    body.storage.sort_if_needed()
    assert body.storage.short_runs is since, "nothing left its slab"
    nodes = sim.grid.nodes
    index, _ = sim.grid.where()
    nodes.velocity[index] = (1.0, 0.0, 0.0)
    nodes.strain_velocity[index] = (1.0, 0.0, 0.0)
    steps = 0
    while not body.storage.slabs.left_slab.any():
        body.update_stress(0.125, move=True)
        steps += 1
        assert steps < 1000
    body.storage.sort_if_needed()
    assert not body.storage.slabs.left_slab.any()
    assert not np.array_equal(body.storage.slabs.first, first)
    cells = node_of(sim.grid, body.points.position)
    assert np.all(np.diff(cells) >= 0)


def vectors_of(cells, first):
    """How many vectors the points of these cells take in this order, slab by slab and block by block."""
    count = 0
    for start, end in pairwise(first):
        for block in range(start, end, BLOCK):
            here = cells[block : min(block + BLOCK, end)]
            runs = np.split(here, np.flatnonzero(np.diff(here)) + 1)
            count += sum(-(-len(run) // LANES) for run in runs)
    return count


@pytest.mark.parametrize("functions", GRID_FUNCTIONS)
def test_points_as_they_were_seeded_make_long_runs(functions):
    """Four points, two by two, share their nodes in each layer of a cell: vectors are full but at walls and ends of blocks."""
    counts = (12, 12, 12)
    grid = Grid(case(box((0, 0, 0), counts), counts=counts).grid)
    position = (np.indices((24, 24, 24)).reshape(3, -1).T + 0.5) / 2.0
    arrays = {"position": np.random.default_rng(1).permutation(position)}
    slabs = sorted_into_slabs(arrays, grid, grid_functions(functions, (2, 2, 2), grid.thin))
    per_cell = {"gimp": 0.5 / 2, "trilinear": 0.0, "quadratic-bspline": 0.5, "cubic-bspline": 1.0}
    nodes = np.floor(arrays["position"] - per_cell[functions]).astype(int)
    start = np.ravel_multi_index(np.clip(nodes, 0, 11 - (functions == "cubic-bspline")).T, counts)
    assert vectors_of(start, slabs.first) <= 0.3 * len(position)


def test_points_that_mix_within_their_slab_are_sorted_when_that_pays():
    """A shear flow along the layers of the slabs: no point ever leaves its slab."""
    sim = Simulation(shear_flow(), threads=1)
    body = sim.bodies[0]
    price = body.sorting_cost * body.n_points + EACH_SORTING
    fewest, excess, sortings = body.n_points, 0, 0
    for _ in range(26):
        since = body.storage.short_runs  # the last sorting
        cells = node_of(sim.grid, body.points.position)
        assert not body.storage.slabs.left_slab.any()
        sim.step()
        sorted_now = body.storage.short_runs is not since
        assert sorted_now == (excess >= price)
        if sorted_now:
            sortings, fewest, excess, cells = sortings + 1, body.n_points, 0, np.sort(cells)
        vectors = vectors_of(cells, body.storage.slabs.first)
        assert vectors == body.storage.slabs.sums[:, VECTORS].sum()
        fewest = min(fewest, vectors)
        excess += vectors - fewest
    assert sortings >= 2


def test_points_that_move_as_one_along_the_slabs_are_not_sorted():
    """Half of a cell's points go on to the next cell: their runs stay as long as they were."""
    sim = simulation(box((3, 0, 0), (12, 4, 4), velocity=(1.0, 0, 0)), counts=(30, 4, 4), support=SLIP, step=0.02, end=10.0)
    body = sim.bodies[0]
    since, x = body.storage.short_runs, body.points.position[0, 0]
    advance(sim, 40)
    assert body.points.position[0, 0] > x + 0.7
    assert body.storage.short_runs is since, "the last sorting is that at the start"
    assert not body.storage.slabs.left_slab.any()
    assert not body.state_arrays()["slabs/short_runs"][0]


def test_where_runs_shorten_evenly_sorting_costs_what_they_did():
    n, more = 100_000, 1_000
    runs, step = ShortRuns(n, 1.0), 0
    while not runs.sorting_pays:
        runs.add(0.25 * n + more * step)
        step += 1
    # the best interval: with m vectors more in each step, m t² / 2 and the price of a sorting are least for their sum over t
    assert step == pytest.approx(np.sqrt(2.0 * (n + EACH_SORTING) / more), abs=2.0)


def test_vectors_that_sorting_does_not_save_are_not_counted():
    runs = ShortRuns(1000, 1.0)
    for vectors in [700.0] * 100 + [650.0] * 100:
        runs.add(vectors)
    assert runs.counts.tolist() == [0.0, 650.0]


def test_points_on_every_wall_and_corner_are_sorted():
    sim = simulation(box((0, 0, 0), (2, 2, 2), per_cell=(1, 1, 1)), counts=(2, 2, 2))
    corners = np.array([(x, y, z) for x in (0, 2) for y in (0, 2) for z in (0, 2)], dtype=float)
    place(sim.bodies[0], corners)
    assert np.array_equal(np.sort(node_of(sim.grid, sim.bodies[0].points.position)), np.arange(8))
    sim.step()
