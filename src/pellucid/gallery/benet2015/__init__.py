"""Cases of Benet 2015: fluid films."""
