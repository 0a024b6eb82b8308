"""Studies: a case run many times, for the order of convergence, for the dependence on parameters, for fits to measurements."""
