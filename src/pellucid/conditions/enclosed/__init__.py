"""What membranes enclose: its volume, gas or liquid by mass, and volumes that are given."""
