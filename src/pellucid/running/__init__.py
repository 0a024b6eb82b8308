"""Runs: compute a case and write its results, resume a run, forecast its steps and run time, verify cases."""
