"""The cube drawn out and pressed together between two plates, on finer and finer meshes.

python reference.py extension > extension.csv
python reference.py compression > compression.csv
python reference.py graded > compression-graded.csv
python reference.py bulge > ../../src/pellucid/references/cube_bulge.csv
"""

import sys

import numpy as np
from cube import HALF, Cube
from statics import LAWS

HEIGHTS = np.linspace(0.0, HALF, 21)


def extended(form, mixed, counts):
    """Cubes drawn out by 0.05 m, graded towards the plate and the free sides: one in steps, then each from the last."""
    last = None
    for n in counts:
        cube = Cube(n, LAWS[form], mixed, power=2.0)
        if last is None:
            for moved in np.linspace(0.005, 0.05, 10):
                cube.move(moved)
        else:
            cube.start(last)
        last = cube
        yield n, cube


def extension():
    print("# the cube drawn out by 0.05 m: reference.py extension. Nodes of one eighth; J, N")
    print("form,formulation,bricks,nodes,energy,reaction")
    for form in LAWS:
        for mixed, counts in ((False, (3, 4, 6)), (True, (3, 4, 6, 8))):
            for n, cube in extended(form, mixed, counts):
                name = "mixed" if mixed else "displacement"
                print(f"{form},{name},{n},{len(cube.bricks.points)},{cube.energy():.8f},{cube.reaction():.6f}", flush=True)


def bulge():
    finest = {form: list(extended(form, True, (4, 8)))[-1][1].bulge(HEIGHTS) for form in LAWS}
    print("# The free sides of the cube drawn out by 0.05 m: validation/mountris2019-cube/reference.py. m")
    print("z," + ",".join(f"{form}_{what}" for form in LAWS for what in ("face_x", "face_z", "edge_x", "edge_z")))
    for i, z in enumerate(HEIGHTS):
        print(f"{z:.4g}," + ",".join(f"{value:.7g}" for form in LAWS for value in finest[form][i]))


def compression():
    print("# the cube pressed together, sides free to pass the plates: reference.py compression. m, J, N")
    print("form,bricks,moved,energy,reaction,lowest,least_j")
    for form, counts in (("coupled", (2, 3, 4, 6)), ("decoupled", (2, 3, 4))):
        for n in counts:
            cube = Cube(n, LAWS[form], mixed=True, power=1.0)
            for step in range(1, 21):
                try:
                    cube.move(-0.0025 * step)
                except FloatingPointError as error:
                    print(f"{form}, {n} bricks, {-0.0025 * step:g} m: {error}", file=sys.stderr)
                    break
                if step % 2 == 0:
                    least = cube.static.state(cube.u)[1].min()
                    numbers = f"{cube.energy():.7f},{cube.reaction():.5f},{cube.lowest():.5f},{least:.3f}"
                    print(f"{form},{n},{cube.moved:.4f},{numbers}", flush=True)


def graded():
    print("# the cube pressed together, bricks closer together towards plates and sides: reference.py graded. m, J, N")
    print("power,bricks,moved,energy,reaction,lowest,least_j,least_ratio")
    for power, counts in ((2.0, (2, 3, 4, 6)), (3.0, (2, 3, 4))):
        for n in counts:
            cube = Cube(n, LAWS["coupled"], mixed=True, power=power)
            for step in range(1, 9):
                try:
                    cube.move(-0.0025 * step)
                except FloatingPointError as error:
                    print(f"power {power:g}, {n} bricks, {-0.0025 * step:g} m: {error}", file=sys.stderr)
                    break
                if step % 2 == 0:
                    _, j, ratio, _ = cube.static.state(cube.u)
                    numbers = f"{cube.energy():.8f},{cube.reaction():.6f},{cube.lowest():.5f},{j.min():.3f},{ratio.min():.3f}"
                    print(f"{power:g},{n},{cube.moved:.4f},{numbers}", flush=True)


if __name__ == "__main__":
    {"extension": extension, "graded": graded, "compression": compression, "bulge": bulge}[sys.argv[1]]()
