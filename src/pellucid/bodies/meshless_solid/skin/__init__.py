"""The contact surface of a meshless solid."""
