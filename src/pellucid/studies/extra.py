"""Import of the packages of the optional extra `sweep` (pandas, dask, optuna and others) at the time at which a study needs
them."""

from functools import partial

from pellucid.system.extras import needed

need = partial(needed, extra="sweep", what="sweeps and fits")
