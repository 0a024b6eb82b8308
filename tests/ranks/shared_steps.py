"""Steps of some cases, to be run by several processes: prints what they come to, from the first of them.

python shared_steps.py THREADS [recut] CASE:STEPS...; recut: cut the rows anew every few steps, here and there.
"""

import hashlib
import json
import sys
import warnings

import numpy as np

from pellucid.case import load
from pellucid.ranks import domain as ranks
from pellucid.ranks.domain import domain
from pellucid.ranks.group import processes
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation import ranks as sharing
from pellucid.simulation.simulation import Simulation


def cut_here_and_there():
    """Cut rows every five steps, wherever."""
    generator = np.random.default_rng(1)

    def cuts(cost, n):
        inner = generator.choice(np.arange(1, len(cost)), min(n, len(cost)) - 1, replace=False)
        return np.concatenate([[0], np.sort(inner), np.full(1 + n - min(n, len(cost)), len(cost))])

    sharing.INTERVAL, ranks.cuts_of, ranks.Domain.would_pay = 5, cuts, lambda self, cost: True


def digest(values):
    return hashlib.sha256(values).hexdigest()[:16]


def steps(name, n, threads):
    case = load(name).quick_variant()
    simulation = Simulation(case, threads=threads)
    probes, rows = ProbeReader(case.probe), []
    probes.start(simulation.bodies)
    for step in range(n):
        simulation.step()
        if step % 10 == 0:
            known = simulation.energies(), simulation.conservation(), simulation.momentum().tolist()
            rows.append([simulation.dt, known, probes.read(simulation.bodies, simulation.reactions(), simulation.time)])
    arrays = simulation.state_arrays()
    state = b"".join(np.ascontiguousarray(arrays[key]).tobytes() for key in sorted(arrays))
    found = {"history": digest(repr(rows).encode()), "state": digest(state), "bytes": domain.bytes_sent}
    domain.leave()
    return found


def main():
    warnings.simplefilter("ignore")
    processes.join()
    threads, *names = sys.argv[1:]
    if names[0] == "recut":
        cut_here_and_there()
        del names[0]
    found = {}
    for name in names:
        case, _, n = name.partition(":")
        found[case] = steps(case, int(n), int(threads))
    if processes.is_first:
        sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main()
