"""Readers and writers of mesh files, one reader for each format, with common data structures."""
