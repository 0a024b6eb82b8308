"""Mesh checks: faults, element quality, and repairs."""
