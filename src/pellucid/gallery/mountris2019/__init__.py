"""Mountris et al. 2019: meshless solids with maximum-entropy functions in total-Lagrangian form, under very large strain."""
