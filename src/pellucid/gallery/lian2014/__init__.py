"""Lian, Liu & Zhang 2014: membranes of finite elements that touch solids, liquids and gases."""
