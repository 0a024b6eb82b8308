"""Interfaces of bodies and conditions, as models of a case and as objects of a run, and a view of all parts of a case."""
