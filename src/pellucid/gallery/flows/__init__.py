"""Slow and confined flows of liquids with exact solutions."""
