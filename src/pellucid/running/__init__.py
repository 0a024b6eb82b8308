"""Runs: cases computed and their results written, gone on with, foretold, verified."""
