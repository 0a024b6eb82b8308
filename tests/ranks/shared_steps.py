"""Steps of some cases, to be run by several processes: prints what they come to, from the first of them.

python shared_steps.py WAYS CASE:STEPS...: so many steps in each of the ways one after another, such as 1,2+recut: a number of
threads; recut: the rows are cut anew every few steps, here and there.
"""

import hashlib
import json
import sys
import warnings
from contextlib import contextmanager, nullcontext
from unittest import mock

import numpy as np

from pellucid.bodies.material_points.body import MaterialPoints
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.case import load
from pellucid.jit import set_threads
from pellucid.ranks import domain as ranks
from pellucid.ranks.domain import domain
from pellucid.ranks.group import processes
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation import ranks as sharing
from pellucid.simulation.simulation import Simulation


@contextmanager
def cut_here_and_there():
    """Rows are cut every five steps, wherever."""
    generator = np.random.default_rng(1)

    def cuts(cost, n):
        inner = generator.choice(np.arange(1, len(cost)), min(n, len(cost)) - 1, replace=False)
        return np.concatenate([[0], np.sort(inner), np.full(1 + n - min(n, len(cost)), len(cost))])

    always = mock.patch.object(ranks.Domain, "would_pay", return_value=True)
    with mock.patch.object(sharing, "INTERVAL", 5), mock.patch.object(ranks, "cuts_of", cuts), always:
        yield


@contextmanager
def points_counted():
    """How many points get their initial velocities, body by body."""
    counts, initial_velocity = [], SeededBody.initial_velocity

    def counted(self, position):
        counts.append(len(position))
        return initial_velocity(self, position)

    with mock.patch.object(SeededBody, "initial_velocity", counted):
        yield counts


def digest(values):
    return hashlib.sha256(values).hexdigest()[:16]


def steps(name, n, ways):
    case = load(name)
    case = case.quick_variant() if case.quick else case
    with points_counted() as built:
        simulation = Simulation(case, threads=1)
    seeded = [body.n_points for body in simulation.bodies if isinstance(body, MaterialPoints)]
    probes, rows = ProbeReader(case.probe), []
    probes.start(simulation.bodies)
    for way in ways:
        threads, _, recut = way.partition("+")
        set_threads(int(threads))
        with cut_here_and_there() if recut else nullcontext():
            for step in range(n):
                simulation.step()
                if step % 5 == 0:
                    known = simulation.budget.energies(), simulation.budget.conservation(), simulation.momentum().tolist()
                    read = probes.read(simulation.bodies, simulation.budget.reactions(), simulation.time)
                    rows.append([simulation.dt, known, read])
    arrays = simulation.state_arrays()
    state = b"".join(np.ascontiguousarray(arrays[key]).tobytes() for key in sorted(arrays))
    found = {
        "history": digest(repr(rows).encode()),
        "state": digest(state),
        "bytes": domain.bytes_sent,
        "built": sum(built) / sum(seeded),
    }
    domain.leave()
    return found


def main():
    warnings.simplefilter("ignore")
    processes.join()
    ways, *names = sys.argv[1:]
    found = {}
    for name in names:
        case, _, n = name.partition(":")
        found[case] = steps(case, int(n), ways.split(","))
    if processes.is_first:
        sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main()
