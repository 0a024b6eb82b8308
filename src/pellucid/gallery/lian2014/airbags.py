"""Metrics and figures of airbags at rest: a cushion compared with the shape of minimum energy, and a folded bag compared with a
circle; wrinkles of the one, crossings and gaps of the layers of the other."""

from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from pellucid.gallery.exact_curves import compared, energy_metric, vanishing
from pellucid.geometry.meshes.enclosure import heights
from pellucid.references import Array
from pellucid.references.membranes import HEIGHT, PAPER_BAG, POISSON_RATIO_OF_BAG, SIDE, bag_at_rest
from pellucid.results.metrics import Metric
from pellucid.results.pictures.films import recorded
from pellucid.results.pictures.style import COLOURS, Figure, Run, finish_panel, label, new_panels, panels

GAS = ("charge", "air")
CLOSE = 0.25  # cells outside the bag at which a point has leaked
CUSHION_REST = 0.75  # share of the run after which the bag is taken to be at rest
CUSHION_VOLUME, SHAPE, PAPER, CUSHION_PRESSURE, CUSHION_ENERGY = 0.02, 0.03, 0.05, 0.05, 0.01
COMPRESSION = 1e-6  # of the largest tension, for rounding
PARTS = 8  # of the bag, of which one is computed
INSTANTS = (0.0, 0.0005, 0.001, 0.002, 0.004, 0.008)

CUSHION_CAPTIONS = {
    "curves": "Volume, compared with the bag of least energy (dashed) at the final pressure; mean pressure of the gas, "
    "and of its parts over their points.",
    "wrinkles": "Upper sheet from above: ratio of the smaller to the larger principal stress; 0 where the sheet is wrinkled.",
}

CUSHION_METRICS = ("volume", "paper_bag", "height", "half_width", "leak", "pressure", "energy", "compression")


def cushion_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: volume, height and width of the bag at rest; gas points outside the bag; gas pressure at
    rest; largest change of the total energy of gas and bag; largest compressive stress in the sheet."""
    skin: Any = next(body for body in run.case.body if body.name == "bag")
    _same_bag(skin.surface.cushion, skin.material.poisson_ratio)
    times = run.times("bag")
    rest = [float(time) for time in times[times >= CUSHION_REST * times[-1]]]
    volume = float(np.mean([bag_volume(run, time) for time in rest]))
    pressure = float(np.mean([gas_pressure(run, time) for time in rest]))
    least = bag_at_rest(pressure / (skin.material.young_modulus * skin.thickness))
    result = {}
    text = "mean volume of the bag over the last quarter of the run; reference: least energy at the gas pressure"
    result["volume"] = compared(volume, least["volume"], CUSHION_VOLUME, "m³", text)
    text = "mean volume over the last quarter; reference: inextensible flat bag (paper bag) without a dome"
    result["paper_bag"] = compared(volume, PAPER_BAG, PAPER, "m³", text)
    history = run.history
    late = history["time"] >= CUSHION_REST * history["time"][-1]
    for name, what in (("height", "half the height"), ("half_width", "half width in the middle of an edge")):
        value = float(np.mean(history[name][late]))
        text = f"mean {what} over the last quarter; error relative to half the side"
        result[name] = Metric(value, least[name], abs(value - least[name]) / (0.5 * SIDE), SHAPE, "m", text)
    leak = max(_outside(run, float(time)) for time in times)
    text = f"largest share of the gas points more than {CLOSE:g} cells outside the bag"
    result["leak"] = vanishing(leak, 1e-6, text)
    expected = _pressure_of_energy(run, rest)
    text = "mean gas pressure; reference: (γ-1)/V times (initial energy - energy of the sheet - kinetic energy)"
    result["pressure"] = compared(pressure, expected, CUSHION_PRESSURE, "Pa", text)
    total = np.sum([history[f"{name}_energy"] for name in ("internal", "kinetic", "strain", "hourglass")], axis=0)
    lost = float(np.abs(total - total[0]).max())
    text = "largest change of the energy of gas and bag; error relative to the initial energy"
    result["energy"] = Metric(lost, 0.0, lost / float(total[0]), CUSHION_ENERGY, "J", text)
    if skin.material.wrinkling:
        lowest, highest = zip(*(_extreme_stresses(run, float(time)) for time in times), strict=True)
        squeezed = max(0.0, -min(lowest)) / max(highest)
        text = "largest compressive principal stress in the sheet, relative to the largest tension of the run"
        result["compression"] = vanishing(squeezed, COMPRESSION, text)
    return result


def cushion_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show volume and gas pressure against time, and the ratio of the principal stresses in the
    sheet, which shows wrinkles, from above."""
    return {"curves": _curves(run), "wrinkles": _wrinkles(run)}


def bag_volume(run: Run, time: float) -> float:
    """Return the volume of the whole bag [m³] in the stored frame nearest to a time [s]: eight times the volume between the
    computed part of the sheet and the plane of its edges."""
    a, b, c = (run.fields("bag", time)["position"][corner] for corner in run.triangles("bag").T)
    plan = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    return PARTS * float(np.sum(plan * (a + b + c)[:, 2]) / 3.0)


def gas_pressure(run: Run, time: float) -> float:
    """Return the volume average of the gas pressure in the bag [Pa] in the stored frame nearest to a time [s]."""
    fields = [run.fields(name, time) for name in GAS]
    volumes = [gas["mass"] / gas["density"] for gas in fields]
    total = sum(float(np.sum(volume * gas["pressure"])) for volume, gas in zip(volumes, fields, strict=True))
    return total / sum(float(volume.sum()) for volume in volumes)


def _same_bag(cushion: Any, poisson_ratio: float) -> None:
    same = cushion is not None and cushion.sides == (SIDE, SIDE) and cushion.height == HEIGHT
    if not (same and set(cushion.halved) == {"x", "y", "z"} and poisson_ratio == POISSON_RATIO_OF_BAG):
        raise ValueError("the reference requires an eighth of the gallery's cushion with its Poisson's ratio")


def _outside(run: Run, time: float) -> float:
    gas = np.concatenate([run.fields(name, time)["position"] for name in GAS])
    height = heights(gas, run.fields("bag", time)["position"], run.triangles("bag"))
    return float(np.mean(height > CLOSE * run.case.grid.cell))


def _pressure_of_energy(run: Run, times: list[float]) -> float:
    """Return the pressure [Pa] that a uniform gas would have in the bag, averaged over the given times [s]. Its energy is the
    initial internal energy minus the strain and kinetic energy."""
    history, charge = run.history, next(body for body in run.case.body if body.name == GAS[0])
    material: Any = charge.material
    energy = history["internal_energy"][0] - history["strain_energy"] - history["kinetic_energy"]
    values = [np.interp(time, history["time"], energy) * PARTS / bag_volume(run, time) for time in times]
    return float((material.eos.gamma - 1.0) * np.mean(values))


def _principal(run: Run, time: float) -> np.ndarray:
    """Return the principal stresses of the sheet's nodes [Pa] in ascending order, shape (n, 3), in the stored frame nearest to
    a time [s], including the zero stress normal to the sheet."""
    xx, yy, zz, yz, xz, xy = run.fields("bag", time)["stress"].T
    return np.linalg.eigvalsh(np.stack([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1))


def _extreme_stresses(run: Run, time: float) -> tuple[float, float]:
    principal = _principal(run, time)
    return float(principal.min()), float(principal.max())


def _curves(run: Run) -> Figure:
    figure, (volume, pressure) = new_panels(1, 2, height=3.6, title=run.case.title)
    times = run.times("bag")
    skin: Any = next(body for body in run.case.body if body.name == "bag")
    pressures = np.array([gas_pressure(run, float(time)) for time in times])
    least = bag_at_rest(float(pressures[-1]) / (skin.material.young_modulus * skin.thickness))
    volume.plot(1e3 * times, [bag_volume(run, float(time)) for time in times], label="bag")
    gas = [
        PARTS * sum(float(np.sum(run.fields(name, t)["mass"] / run.fields(name, t)["density"])) for name in GAS) for t in times
    ]
    volume.plot(1e3 * times, gas, label="gas", linewidth=1.0)
    volume.axhline(least["volume"], color=COLOURS[0], linestyle="--", linewidth=0.8, label="least energy")
    volume.axhline(PAPER_BAG, color="black", linestyle=":", linewidth=0.8, label="paper bag")
    label(volume, "time", "volume", "ms", "m³", legend=True)
    ms = 1e3 * run.history["time"]
    pressure.semilogy(1e3 * times, pressures, color=COLOURS[2], label="all gas, volume average")
    for name, colour in zip(GAS, COLOURS[:2], strict=True):
        pressure.semilogy(ms, run.history[f"{name}_pressure"], color=colour, linewidth=0.8, label=f"{name}, mean of its points")
    label(pressure, "time", "pressure", "ms", "Pa", legend=True)
    return figure


def _wrinkles(run: Run) -> Figure:
    reached = recorded(run.times("bag"), INSTANTS)[-3:]
    figure, subplots = panels(len(reached), len(reached), height=3.4, sharex=True, sharey=True)
    triangles = run.triangles("bag")
    for axes, time in zip(subplots, reached, strict=True):
        position, principal = run.fields("bag", time)["position"], _principal(run, time)
        across = np.argmin(np.abs(principal), axis=1)  # zero, one of the three
        plane = np.array([np.delete(values, skip) for values, skip in zip(principal, across, strict=True)])
        largest = np.abs(plane).max(axis=1)
        share = np.divide(plane[:, 0], largest, out=np.zeros_like(largest), where=largest > 0.0)
        x, y, _ = position.T
        colours = share[triangles].mean(axis=1)
        drawn = axes.tripcolor(x, y, colours, triangles=triangles, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
        finish_panel(axes, f"t = {1e3 * time:.3g} ms", "x", "y", "m")
    figure.colorbar(drawn, ax=subplots, label="smaller / larger principal stress", shrink=0.8)
    return figure


FOLDED_REST = 0.8  # share of the run after which the bag is taken to be at rest
FOLDED_VOLUME, FOLDED_PRESSURE, FOLDED_ENERGY, GAP = 0.01, 0.01, 0.01, 0.1
APART = 4.0  # thicknesses along the sheet from where on two parts are layers

FOLDED_METRICS = ("volume", "pressure", "crossings", "gap", "energy")


def folded_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: volume and gas pressure at rest; number of places at which layers of the bag cross; smallest
    gap of two layers; error of the energy balance."""
    bag: Any = next(body for body in run.case.body if body.name == "bag")
    history, late = run.history, np.asarray(run.history["time"]) >= FOLDED_REST * run.history["time"][-1]
    times, triangles = [float(time) for time in run.times("bag")], run.triangles("bag")
    frames = [np.asarray(run.fields("bag", time)["position"]) for time in times]
    length = float(np.ptp(frames[0][:, 1]))
    gas = float(history["gas_mass"][-1]) * _gas_constant(run) * float(history["gas_temperature"][-1]) / length
    stretch = (1.0 - bag.material.poisson_ratio**2) / (bag.material.young_modulus * bag.thickness)
    radius = circle(circumference(frames[0], triangles), stretch, gas)
    volume, pressure = (float(np.mean(history[name][late])) for name in ("gas_volume", "gas_pressure"))
    gap = least_gap(frames, triangles, bag.thickness)
    of = "mean over the last fifth of the run; reference: a circle with the circumference of both layers"
    text = "smallest distance of two layers in any frame, divided by the thickness; error: shortfall from 1"
    return {
        "volume": compared(volume, pi * radius**2 * length, FOLDED_VOLUME, "m³", of),
        "pressure": compared(pressure, gas / (pi * radius**2), FOLDED_PRESSURE, "Pa", of),
        "crossings": vanishing(float(max(crossings(frame, triangles) for frame in frames)), 0.5, CROSSINGS),
        "gap": Metric(gap, 1.0, max(0.0, 1.0 - gap), GAP, "", text),
        "energy": energy_metric(run, FOLDED_ENERGY),
    }


CROSSINGS = "largest number, in any frame, of edges that cross triangles to which they do not belong"


def circle(circumference: float, stretch: float, gas: float) -> float:
    """Return the radius [m] of a circle whose circumference [m] is stretched by the hoop tension of the enclosed gas.

    stretch: strain per tension (1 - ν²)/(E t) [m/N] of a sheet with Young's modulus E, Poisson's ratio ν and thickness t;
    gas: product of pressure and volume per unit length, m R T [N]. The strains are small, and the length along the axis is
    fixed by planes of symmetry.
    """
    start = radius = circumference / (2.0 * pi)
    for _ in range(100):
        radius = start * (1.0 + gas / (pi * radius**2) * radius * stretch)
    return radius


def _gas_constant(run: Run) -> float:
    enclosed: Any = next(enclosed for enclosed in run.case.enclosed if enclosed.name == "gas")
    return float(enclosed.gas.gas_constant)


def _edges(triangles: Array) -> Array:
    return np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)


def circumference(position: Array, triangles: Array) -> float:
    """Return the length of the edges in the lower plane of symmetry [m], i.e. the circumference of the bag. position: [m],
    shape (n, 3); triangles: node numbers, shape (m, 3)."""
    edges, low = _edges(triangles), position[:, 1] < position[:, 1].min() + 1e-9
    rim = edges[low[edges].all(axis=1)]
    return float(np.linalg.norm(position[rim[:, 0]] - position[rim[:, 1]], axis=1).sum())


def least_gap(frames: list[Array], triangles: Array, thickness: float) -> float:
    """Return the smallest distance of vertices from triangles of other layers in all stored frames, divided by the thickness
    (no unit).

    frames: positions of the nodes in each stored frame [m], shape (n, 3). triangles: node numbers, shape (m, 3). thickness: of
    the sheet [m]. Triangles belong to another layer if they are at least `APART` thicknesses (a constant of this module) away
    along the sheet and at least one thickness away at the start; near the rims, the layers of a flat bag are closer. The
    function is independent of the distances computed by contact.
    """
    start, edges = frames[0], _edges(triangles)
    lengths = np.linalg.norm(start[edges[:, 0]] - start[edges[:, 1]], axis=1)
    graph = sparse.csr_array((lengths, edges.T), shape=(len(start), len(start)))
    along, least = dijkstra(graph, directed=False), np.inf
    for frame in frames:
        corners = frame[triangles]
        middles = corners.mean(axis=1)
        reach = thickness + float(np.linalg.norm(corners - middles[:, None], axis=2).max())
        near = cKDTree(frame).sparse_distance_matrix(cKDTree(middles), reach, output_type="coo_matrix")
        p, t = near.row, near.col
        other = along[p[:, None], triangles[t]].min(axis=1) > APART * thickness
        p, t = p[other], t[other]
        if len(p):
            apart = distances(start[p], start[triangles[t]]) >= thickness
            found = distances(frame[p[apart]], corners[t[apart]])
            least = min(least, float(found.min(initial=np.inf)))
    return min(least / thickness, 1.0 + APART)


def distances(points: Array, corners: Array) -> Array:
    """Return the distance [m] of each point, shape (n, 3), from the triangle with the same number; corners: shape (n, 3, 3)
    [m]."""
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    square = np.full(len(points), np.inf)
    for i in range(3):
        first, edge = corners[:, i], corners[:, (i + 1) % 3] - corners[:, i]
        share = np.einsum("nd,nd->n", points - first, edge) / np.einsum("nd,nd->n", edge, edge)
        foot = first + np.clip(share, 0.0, 1.0)[:, None] * edge
        square = np.minimum(square, ((points - foot) ** 2).sum(axis=1))
    normal, away = np.cross(ab, ac), points - a
    size = np.einsum("nd,nd->n", normal, normal)
    u = np.einsum("nd,nd->n", np.cross(away, ac), normal) / size
    v = np.einsum("nd,nd->n", np.cross(ab, away), normal) / size
    inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    return np.sqrt(np.where(inside, np.einsum("nd,nd->n", away, normal) ** 2 / size, square))


def crossings(vertices: Array, triangles: Array) -> int:
    """Return the number of pairs of an edge and a triangle of a surface, without a common vertex, that intersect. vertices:
    [m], shape (n, 3); triangles: shape (m, 3)."""
    a, ab, ac = vertices[triangles[:, 0]], *(vertices[triangles[:, i]] - vertices[triangles[:, 0]] for i in (1, 2))
    low, high = vertices[triangles].min(axis=1), vertices[triangles].max(axis=1)
    found = 0
    for first, second in _edges(triangles):
        p, d = vertices[first], vertices[second] - vertices[first]
        near = np.all((low <= np.maximum(p, p + d)) & (high >= np.minimum(p, p + d)), axis=1)
        near &= ~np.any((triangles == first) | (triangles == second), axis=1)
        h = np.cross(d, ac[near])
        det = np.einsum("ij,ij->i", ab[near], h)
        safe = np.where(np.abs(det) < 1e-300, 1.0, det)
        t = p - a[near]
        u, q = np.einsum("ij,ij->i", t, h) / safe, np.cross(t, ab[near])
        v, w = q @ d / safe, np.einsum("ij,ij->i", ac[near], q) / safe
        found += int(np.count_nonzero((np.abs(det) > 1e-300) & (u > 0) & (v > 0) & (u + v < 1) & (w > 0) & (w < 1)))
    return found


CASES = {
    "airbag": SimpleNamespace(
        METRICS=CUSHION_METRICS, CAPTIONS=CUSHION_CAPTIONS, metrics=cushion_metrics, figures=cushion_figures
    ),
    "folded-airbag": SimpleNamespace(METRICS=FOLDED_METRICS, metrics=folded_metrics),
}
"""Metrics, captions and figures of each case, by its name without the group."""
