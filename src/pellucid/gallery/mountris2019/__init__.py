"""Lian, Liu & Zhang 2014: membranes of finite elements that touch material points on the grid."""
