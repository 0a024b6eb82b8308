"""Metrics of the folded airbag: its volume and pressure at rest compared with a circle; crossings and gaps of its layers."""

from math import pi
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from pellucid.gallery.exact_curves import compared, energy_metric, vanishing
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

REST = 0.8  # share of the run after which the bag is taken to be at rest
VOLUME, PRESSURE, ENERGY, GAP = 0.01, 0.01, 0.01, 0.1
APART = 4.0  # thicknesses along the sheet from where on two parts are layers

METRICS = ("volume", "pressure", "crossings", "gap", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: volume and gas pressure at rest; number of places at which layers of the bag cross; smallest
    gap of two layers; error of the energy balance."""
    bag: Any = next(body for body in run.case.body if body.name == "bag")
    history, late = run.history, np.asarray(run.history["time"]) >= REST * run.history["time"][-1]
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
        "volume": compared(volume, pi * radius**2 * length, VOLUME, "m³", of),
        "pressure": compared(pressure, gas / (pi * radius**2), PRESSURE, "Pa", of),
        "crossings": vanishing(float(max(crossings(frame, triangles) for frame in frames)), 0.5, CROSSINGS),
        "gap": Metric(gap, 1.0, max(0.0, 1.0 - gap), GAP, "", text),
        "energy": energy_metric(run, ENERGY),
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
