import pandas as pd

from pellucid.studies.sweep import LEAST, sensitivities


def table(n: int) -> pd.DataFrame:
    from scipy.stats import qmc

    a, b, c = qmc.LatinHypercube(3, rng=1).random(n).T
    return pd.DataFrame({"state": "done", "a": a, "b": b, "c": c, "y": 3 * a + 2 * b})


def test_shares_of_variance_are_those_of_the_function() -> None:
    found = {one.key: one.share for one in sensitivities(table(400), ["a", "b", "c"], ["y"])}
    assert abs(found["a"] - 9 / 13) < 0.05
    assert abs(found["b"] - 4 / 13) < 0.05
    assert abs(found["c"]) < 0.05


def test_a_small_sample_says_nothing() -> None:
    assert sensitivities(table(LEAST - 1), ["a", "b", "c"], ["y"]) == []
