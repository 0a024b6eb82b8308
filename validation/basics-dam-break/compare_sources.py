"""Is the table that the package carries the experiment's? Compare it with figure 3 as others digitised it.

python compare_sources.py
"""

from pathlib import Path

import numpy as np

from pellucid.references.flows import martin_moyce

if __name__ == "__main__":
    digitised = np.loadtxt(Path(__file__).parent / "figure3.csv", delimiter=",", skiprows=3)
    time, front = martin_moyce("front")
    both = (digitised[:, 0] >= time[0]) & (digitised[:, 0] <= time[-1] + 0.02)
    t, z = digitised[both].T
    table = np.interp(t, time, front)
    for row in zip(t, z, table, z / table - 1.0, strict=True):
        print("T = {:.3f}: figure {:.3f}, table {:.3f}, difference {:+.1%}".format(*row))
