"""Figures and films of a run, drawn with numpy and matplotlib alone."""
