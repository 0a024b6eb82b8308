"""Mountris et al. 2019: meshless solids of maximum entropy in total-Lagrangian form, under very large strain."""
