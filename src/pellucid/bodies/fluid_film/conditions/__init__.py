"""What constrains a film: its volume and area, nodes whose velocity is prescribed, loads that nothing balances."""
