"""Studies: a case run many times, for the order of convergence, for the dependence on parameters, to fit these to measurements."""
