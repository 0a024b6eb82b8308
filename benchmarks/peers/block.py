"""Problem that both peer scripts compute: a cube full of points, eight per cell, with walls that hold the normal velocity.

SI units, double precision. The points are created cell by cell, so they start sorted, which favours the peer.
"""

import argparse
import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

CELL = 0.01  # m
DENSITY = 1000.0  # kg/m^3
YOUNG_MODULUS, POISSON_RATIO = 1.0e6, 0.3  # Pa, 1
GAMMA, PRESSURE = 1.4, 1.0e5  # 1, Pa
QUADRATIC, LINEAR = 2.0, 1.0  # artificial viscosity
SPEED = {"hypoelastic": 0.5, "ideal-gas": 3.0}  # m/s, amplitude of the initial velocity wave
BLOCKS = 3
COURANT = 0.2  # the artificial viscosity brings a tighter bound than the sound speed alone

LAME_MU = YOUNG_MODULUS / (2.0 * (1.0 + POISSON_RATIO))
LAME_LAMBDA = YOUNG_MODULUS * POISSON_RATIO / ((1.0 + POISSON_RATIO) * (1.0 - 2.0 * POISSON_RATIO))


@dataclass(frozen=True)
class Block:
    """Points and grid of the problem: positions [m] and velocities [m/s], shape (n, 3); nodes along an axis; time step [s];
    mass of a point [kg]."""

    position: np.ndarray
    velocity: np.ndarray
    nodes: int
    step: float
    mass: float


def make_block(points: int, law: str) -> Block:
    """Return a cube of about `points` points; law: "hypoelastic" or "ideal-gas", whose wave speed sets the time step."""
    cells = max(2, round((points / 8) ** (1 / 3)))
    cell = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    corner = np.stack(np.meshgrid(*[[0.25, 0.75]] * 3, indexing="ij"), axis=-1).reshape(1, 8, 3)
    position = (cell + corner).reshape(-1, 3) * CELL
    velocity = np.zeros_like(position)
    velocity[:, 0] = SPEED[law] * np.sin(2.0 * np.pi * position[:, 0] / (cells * CELL))
    if law == "ideal-gas":
        sound = np.sqrt(GAMMA * PRESSURE / DENSITY)
    else:
        sound = np.sqrt((LAME_LAMBDA + 2.0 * LAME_MU) / DENSITY)
    step = COURANT * CELL / (sound + SPEED[law])
    return Block(position, velocity, cells + 1, float(step), DENSITY * CELL**3 / 8)


def options(description: str | None) -> argparse.Namespace:
    """Return the command line arguments that both scripts share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--law", choices=("hypoelastic", "ideal-gas"), default="hypoelastic")
    parser.add_argument("--scheme", choices=("usl", "musl"), default="usl", help="musl maps the momentum a second time")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def measure(
    name: str, arguments: argparse.Namespace, block: Block, step: Callable[[], None], state: Callable[[], np.ndarray]
) -> None:
    """Warm up (which also compiles), time three blocks of `arguments.steps` steps, and print the rate of the fastest.

    `state` waits for work under way and returns the point velocities [m/s], shape (n, 3); their mean square is printed
    so that the results of the programs can be compared.
    """
    for _ in range(3):
        step()
    state()
    seconds = float("inf")
    for _ in range(BLOCKS):
        start = time.perf_counter()
        for _ in range(arguments.steps):
            step()
        velocity = state()
        seconds = min(seconds, time.perf_counter() - start)
    if not np.isfinite(velocity).all():
        raise SystemExit("the run became unstable: its speed means nothing")
    result = {
        "peer": name,
        "law": arguments.law,
        "scheme": arguments.scheme,
        "points": len(block.position),
        "steps": arguments.steps,
        "threads": arguments.threads,
        "seconds": seconds,
        "point_steps_per_second": len(block.position) * arguments.steps / seconds,
        "mean_square_velocity": float(np.mean(np.sum(velocity**2, axis=1))),
    }
    if arguments.json:
        print(json.dumps(result))
    else:
        print(
            f"{name}: {result['point_steps_per_second'] / 1e6:.2f} M particle-steps/s "
            f"({result['points']} points, {arguments.law}, {arguments.scheme}, {arguments.threads} threads; "
            f"mean square velocity {result['mean_square_velocity']:.12e} m^2/s^2)"
        )
