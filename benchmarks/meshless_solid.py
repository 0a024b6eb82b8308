"""The finest mesh of Mountris et al. 2019, of about 50 000 nodes and 300 000 tetrahedra with four points each: what its tables
cost to build and to keep, and the updates of its points a second on one thread and on two.

Run it with `python benchmarks/meshless_solid.py [points]`; it takes minutes. Numbers: docs/reference/speed.md.
"""

import json
import sys

from pellucid.bench.meshless import measure

FINEST = 1_170_000  # quadrature points
STEPS = 60

if __name__ == "__main__":
    points = int(float(sys.argv[1])) if len(sys.argv) > 1 else FINEST
    for threads in (2, 1):
        print(json.dumps(measure(points, STEPS, threads), indent=1), flush=True)
