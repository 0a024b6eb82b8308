"""Studies that run a case many times: orders of convergence, dependence on parameters, fits to measurements."""

from functools import partial

from pellucid.system.extras import needed

need = partial(needed, extra="sweep", what="sweeps and fits")
