"""Lian, Liu & Zhang 2014: finite-element membranes in contact with solids, liquids and gases."""
