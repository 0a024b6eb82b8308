"""What is wrong with meshes, how well shaped their elements are, and what can be mended."""
