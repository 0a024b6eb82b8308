"""What membranes share, whether points or elements carry their stress."""
