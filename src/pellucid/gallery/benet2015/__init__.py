"""Cases of Benet 2015 and related cases."""
