"""Import of packages of the extra `sweep` (pandas, dask, optuna and others) when they are needed."""

from functools import partial

from pellucid.system.extras import needed

need = partial(needed, extra="sweep", what="sweeps and fits")
