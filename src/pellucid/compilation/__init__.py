"""Kernels of a case: which it needs, their compilation ahead of a run or beside it, and what users are told of it."""
