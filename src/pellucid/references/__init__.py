"""Exact solutions and measured data that gallery cases are compared with."""
