"""How far a block slips whose weight is switched on at once: a column of springs on a slope of 30 degrees, in one dimension.

Waves of pressure and of shear run in it; its foot is on a rigid base that presses and never pulls, with Coulomb friction, and
nothing is damped. The foot lifts off once in a period of the waves of pressure, so that it slips although friction, 0.7, is
above the slope. Nothing here is shared with the package.

    python column.py > column.csv
"""

import numpy as np

HEIGHT, YOUNG, POISSON, DENSITY = 0.25, 1e7, 0.3, 2000.0
ALONG, ACROSS = 9.81 * np.sin(np.radians(30.0)), 9.81 * np.cos(np.radians(30.0))
INSTANTS = np.arange(1, 9) * 0.1


def slip(friction, n):
    """Mean displacement along the slope [m] at the instants, for n springs."""
    pressure = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
    shear = YOUNG / 2 / (1 + POISSON)
    h = HEIGHT / n
    dt = 0.5 * h / np.sqrt(pressure / DENSITY)
    mass = np.full(n + 1, DENSITY * h)
    mass[[0, -1]] *= 0.5
    stiff = np.array([[shear], [pressure]]) / h
    pull = np.array([[ALONG], [-ACROSS]])
    place, velocity, force = np.zeros((2, n + 1)), np.zeros((2, n + 1)), np.zeros((2, n + 1))
    found = []
    for step in range(1, round(INSTANTS[-1] / dt) + 2):
        stress = stiff * np.diff(place)
        force[:, :-1] = stress
        force[:, -1] = 0.0
        force[:, 1:] -= stress
        velocity += dt * (force / mass + pull)
        depth = -(place[1, 0] + dt * velocity[1, 0])
        if depth > 0.0:
            push = depth / dt * mass[0]
            velocity[1, 0] += push / mass[0]
            velocity[0, 0] -= np.clip(velocity[0, 0], -friction * push / mass[0], friction * push / mass[0])
        place += dt * velocity
        if len(found) < len(INSTANTS) and step * dt >= INSTANTS[len(found)]:
            found.append(float(mass @ place[0] / mass.sum()))
    return found


if __name__ == "__main__":
    print("# slip of a column on a slope of 30 degrees, its weight switched on at once; see column.py")
    print("time_s," + ",".join(f"slip_{n}_springs_m" for n in (25, 50, 100)))
    columns = [slip(0.7, n) for n in (25, 50, 100)]
    for time, *values in zip(INSTANTS, *columns, strict=True):
        print(f"{time:.1f}," + ",".join(f"{value:.5f}" for value in values))
