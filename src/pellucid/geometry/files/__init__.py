"""Files of meshes: one reader for each format, and what all of them give."""
