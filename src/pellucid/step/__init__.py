"""What acts in a step: the interface of its parts, and the limits of its length."""
