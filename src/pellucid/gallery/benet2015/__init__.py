"""Cases of Benet 2015 and related cases: vesicles and drops as fluid films, and diffusion."""
