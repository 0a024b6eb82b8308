"""The order of the verbs in a step. No physics here; bodies and grid hold it.

USF, USL and MUSL strain the points first, last, and last with the velocities mapped anew from the points
(Sulsky, Zhou & Schreyer 1995, Comput. Phys. Commun. 87, 236; Bardenhagen 2002, J. Comput. Phys. 180, 383). As there, a point
uses the shape functions of its place at the start of the step throughout.
"""

from collections.abc import Callable
from typing import Any


def musl(scene: Any, dt: float) -> None:
    """Modified update stress last, Gan's order."""
    layers = scene.layers
    layers.clear_inertia()
    layers.clear_force()
    for body in scene.bodies:
        body.to_grid(inertia=True, force=True)  # m, p, f
    scene.meet()  # where fields touch
    scene.advance(dt)  # p + dt f, supports, contact
    layers.clear_momentum()
    for body in scene.bodies:
        body.accelerate(remap=True)  # v of the points, p anew
    scene.project()
    for body in scene.bodies:
        body.deform(dt, move=True)  # x, L, σ


def usl(scene: Any, dt: float) -> None:
    """Update stress last."""
    layers = scene.layers
    layers.clear_inertia()
    layers.clear_force()
    for body in scene.bodies:
        body.to_grid(inertia=True, force=True)
    scene.meet()
    scene.advance(dt)
    if scene.touching:
        layers.clear_momentum()
    for body in scene.bodies:
        body.accelerate(remap=scene.touching)  # p anew for contact
    for body in scene.bodies:
        body.deform(dt, move=True)


def usf(scene: Any, dt: float) -> None:
    """Update stress first."""
    layers = scene.layers
    layers.clear_inertia()
    for body in scene.bodies:
        body.to_grid(inertia=True, force=False)
    scene.meet()
    scene.project()
    for body in scene.bodies:
        body.deform(dt, move=False)
    layers.clear_force()
    for body in scene.bodies:
        body.to_grid(inertia=False, force=True)
    scene.advance(dt)
    if scene.touching:
        layers.clear_momentum()
    for body in scene.bodies:
        body.accelerate(remap=scene.touching)
    for body in scene.bodies:
        body.move(dt)


SCHEMES: dict[str, Callable[[Any, float], None]] = {"musl": musl, "usl": usl, "usf": usf}
