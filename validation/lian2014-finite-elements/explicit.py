"""The two cases and their integration by central differences."""

from dataclasses import dataclass, field

import numpy as np
from ball import Ball
from contact import meet
from sheet import Sheet

HALF, THICKNESS = 0.025, 1e-4
ENDS = {"membrane-on-sphere": 5e-4, "sphere-on-membrane": 6e-4}
COLUMNS = {"membrane-on-sphere": ("centre_z", "corner_z"), "sphere-on-membrane": ("membrane_z", "sphere_top_z")}


@dataclass
class Choice:
    """How a case is computed: lengths in m, times in s."""

    case: str
    spacing: float = 1e-3  # side of the sheet's elements
    ball: tuple[int, int] = (16, 6)  # elements along a cube's side, layers outside the core
    rigid: bool = False
    penalty: float = 0.0  # 0: impacts do not rebound; otherwise the spring of a node of mass m is penalty m / dt^2
    tension_field: bool = False
    central: float = 0.0  # share of the stress taken at the elements' centres
    courant: float = 0.5
    noise: float = 0.0  # the sheet's nodes start up to so far above or below the plane
    seed: int = 0
    end: float = 0.0  # 0: the case's
    rows: int = 250
    shapes: tuple[float, ...] = ()


@dataclass
class Found:
    """times (k,) [s], curves (k, 2) [m]; balances: largest errors over energy and momentum at the start."""

    times: np.ndarray
    curves: np.ndarray
    steps: int
    energy: float
    momentum: float
    absorbed: float  # share of the energy that contact took
    shapes: dict[float, np.ndarray] = field(default_factory=dict)


def bodies(choice):
    """Sheet and ball of a case, as the paper has them."""
    n = round(HALF / choice.spacing)
    if choice.case == "membrane-on-sphere":
        sheet = Sheet(HALF, n, THICKNESS, 10e9, 0.3, 750.0, 0.031, 50.0, clamped=False)
        ball = Ball(0.015, *choice.ball, 70e9, 0.3, 2750.0, 0.015, 0.0, held_below=0.001, rigid=choice.rigid)
    else:
        sheet = Sheet(HALF, n, THICKNESS, 70e9, 0.3, 750.0, 0.0, 0.0, clamped=True)
        ball = Ball(0.0045, *choice.ball, 70e9, 0.3, 750.0, 0.0055, -10.0, held_below=-1.0, rigid=choice.rigid)
    sheet.x[:, 2] += choice.noise * np.random.default_rng(choice.seed).uniform(-1, 1, len(sheet.x)) * sheet.free[:, 2]
    return sheet, ball


def run(choice):
    """One computation of a case."""
    sheet, ball = bodies(choice)
    clamped = choice.case == "sphere-on-membrane"
    end = choice.end or ENDS[choice.case]
    steps = int(np.ceil(end / (choice.courant * min(sheet.h / sheet.wave_speed, ball.longest_step()))))
    dt = end / steps
    instants = set(np.round(np.linspace(0, steps, choice.rows + 1)).astype(int))
    drawn = {round(t / dt): t for t in choice.shapes}
    times, curves, energies, momenta, shapes = [], [], [], [], {}
    given = worked = 0.0  # by contact: impulse on the sheet along z [N s], work on both [J]
    for step in range(steps + 1):
        force, strain = sheet.forces(choice.tension_field, choice.central)
        before, ball_before = sheet.v.copy(), ball.v.copy()
        sheet.v += dt * force * sheet.free / sheet.mass[:, None]
        if not ball.rigid:
            pull = (ball.K @ ball.u.ravel()).reshape(-1, 3)
            ball.v -= dt * pull * ball.inverse_mass
            strain += 0.5 * np.sum(ball.u * pull)
        trial, ball_trial = sheet.v.copy(), ball.v.copy()
        impulse = meet(sheet, ball, dt, choice.penalty)
        work = 0.5 * np.sum(sheet.mass[:, None] * (sheet.v - trial) * (before + sheet.v))
        work += 0.5 * np.sum(ball.mass[:, None] * (ball.v - ball_trial) * (ball_before + ball.v))
        if step in instants:
            moving = _kinetic(sheet, before) + _kinetic(sheet, sheet.v) + _kinetic(ball, ball_before) + _kinetic(ball, ball.v)
            top = ball.X[ball.top, 2] + ball.u[ball.top, 2]
            times.append(step * dt)
            curves.append((sheet.x[0, 2], top if clamped else sheet.x[-1, 2]))
            energies.append((0.5 * moving + strain - worked - 0.5 * work, worked))
            # the clamped sides and the held bottom push too: the balance is that of the body that is free
            momenta.append(_momentum(ball, ball_before) + given if clamped else _momentum(sheet, before) - given)
        if step in drawn:
            shapes[drawn[step]] = sheet.x.copy()
        given += impulse
        worked += work
        sheet.x += dt * sheet.v
        ball.u += dt * ball.v
    energy, momentum = np.array(energies), np.array(momenta)
    return Found(
        np.array(times),
        np.array(curves),
        steps,
        float(np.abs(energy[:, 0] / energy[0, 0] - 1.0).max()),
        float(np.abs(momentum / momentum[0] - 1.0).max()),
        float(-energy[-1, 1] / energy[0, 0]),
        shapes,
    )


def _kinetic(body, v):
    return 0.5 * np.sum(body.mass[:, None] * v * v)


def _momentum(body, v):
    return np.sum(body.mass * v[:, 2])
