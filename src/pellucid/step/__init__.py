"""Interface of the parts that act in a step, and limits of its length."""
