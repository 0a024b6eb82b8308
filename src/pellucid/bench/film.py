"""Cost of a step of a film in space: an ellipsoid with bending that approaches a smaller volume at a given area."""

import time
from collections.abc import Callable
from typing import Any, cast

from pellucid.bench.machine import peak_bytes
from pellucid.bench.problem import problem
from pellucid.bodies.fluid_film.body import FluidFilm
from pellucid.bodies.fluid_film.solvers import SparseSolver
from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

SMALLEST = 162  # nodes, for what compiles the kernels
WARM_UP_STEPS = 12  # its own steps double until they are as long as its accuracy allows
CLOCK_STEP = 2e-3  # s, near those of its own with 10 242 nodes


def film_case(points: int) -> Case:
    """Build the case of a prolate vesicle as in `benet2015/vesicle-in-space`, with the finest subdivided icosahedron of at
    most `points` nodes."""
    refinements = 2
    while 10 * 4 ** (refinements + 1) + 2 <= points:
        refinements += 1
    film = {
        "name": "film",
        "kind": "fluid-film",
        "shape": {"surface": {"ellipsoid": {"radii": [1.0, 1.0, 1.7], "refinements": refinements}}},
        "material": {
            "kind": "lipid-film",
            "density": 1.0,
            "viscosity": 1.0,
            "dilatational_viscosity": 1.0,
            "stiffness": 100.0,
            "bending_rigidity": 1.0,
        },
        "volume": {"reduced": 0.9, "over": 0.5},
        "area": "kept",
        "drag": {"normal": 0.1, "tangential": 0.1},
    }
    return problem("film", [film], output={"history": CLOCK_STEP})


def measure(points: int, steps: int, threads: int | None) -> dict[str, Any]:
    """Measure the wall-clock time of a step of a film with at most `points` nodes, averaged over at least `steps` of its own
    time steps. Keys of the result as in `pellucid.bench.whole.bench`."""
    Simulation(film_case(SMALLEST), threads=threads).step()  # compiles the kernels or loads them
    before, start = peak_bytes(), time.perf_counter()
    simulation = Simulation(film_case(points), threads=threads)
    build_seconds = time.perf_counter() - start
    film = cast(FluidFilm, simulation.bodies[0])
    seconds: dict[str, float] = {}
    counts: dict[str, int] = {}
    _time_parts(film, seconds, counts)
    while counts.get("step", 0) < WARM_UP_STEPS:
        simulation.step()
    seconds.clear()
    counts.clear()
    start, processor_start = time.perf_counter(), time.process_time()
    while counts.get("step", 0) < steps:
        simulation.step()
    whole, taken = time.perf_counter() - start, counts["step"]
    parts = {part: seconds.get(part, 0.0) / whole for part in ("matrix", "factor", "iteration", "nodes")}
    return {
        "points": film.n_points,
        "steps": taken,
        "build_seconds": build_seconds,
        "seconds_per_step": whole / taken,
        "processor_seconds_per_step": (time.process_time() - processor_start) / taken,
        "factors_per_step": counts.get("factor", 0) / taken,
        "bytes_per_point": (peak_bytes() - before) / film.n_points,
        "parts": {**parts, "rest": 1.0 - sum(parts.values())},
    }


def _time_parts(film: FluidFilm, seconds: dict[str, float], counts: dict[str, int]) -> None:
    """Replace methods of a film by timed ones, which add wall-clock times [s] and numbers of calls by part of the step (matrix,
    factorization, iteration, nodes) to `seconds` and `counts`."""
    solver = cast(SparseSolver, film.balance.solver)
    timed: list[tuple[Any, str, str]] = [
        (film.balance, "step", "step"),
        (film.geometry, "redistributed", "nodes"),
        (solver.assembly, "matrix", "matrix"),
        (solver, "renew", "factor"),
        (solver, "iterate", "iteration"),
    ]
    for owner, verb, part in timed:
        setattr(owner, verb, _timed(getattr(owner, verb), part, seconds, counts))


def _timed(verb: Callable[..., Any], part: str, seconds: dict[str, float], counts: dict[str, int]) -> Callable[..., Any]:
    def timed(*arguments: Any) -> Any:
        start = time.perf_counter()
        result = verb(*arguments)
        seconds[part] = seconds.get(part, 0.0) + time.perf_counter() - start
        counts[part] = counts.get(part, 0) + 1
        return result

    return timed
