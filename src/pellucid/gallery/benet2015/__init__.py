"""Cases of Benet 2015 and around them."""
