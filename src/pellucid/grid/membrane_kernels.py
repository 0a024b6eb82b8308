"""Straining of membrane points: gradients from the grid, frames from the moved triangles, plane stress from the law.

Source: Gan et al. 2011, section 2.1, with the misprints put right: strains are accumulated in the carried frame, and the frame
also takes the spin about its normal, without which a sheet that turns in its own plane would leave its stress behind.
"""
