"""Kernels of a case: key, compilation before or during a run, and reports of compilation."""
