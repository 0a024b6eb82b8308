"""Compilation of the kernels of a case before or during a run, progress reports, and a key for cases with the same kernels."""
