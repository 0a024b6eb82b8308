"""Studies that run a case many times: orders of convergence, dependence on parameters, fits to measurements."""
