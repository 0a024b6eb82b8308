"""Bodies that move as rigid ones."""
