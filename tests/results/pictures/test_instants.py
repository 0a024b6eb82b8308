import numpy as np
import pytest

from pellucid.results.pictures.films import evenly, recorded

FRAMES = 25e-6 * np.arange(5)


def test_instants_are_thinned_evenly():
    times = np.arange(11.0)
    assert evenly(times, 3).tolist() == [0.0, 5.0, 10.0]
    assert evenly(times, 50).tolist() == times.tolist()


def test_instants_are_those_of_frames_that_the_run_reached():
    assert recorded(FRAMES, (28e-6, 52e-6, 76e-6, 100e-6)) == pytest.approx([25e-6, 50e-6, 75e-6, 100e-6])
    assert recorded(FRAMES, (28e-6, 27e-6, 300e-6)) == pytest.approx([25e-6])
    assert recorded(FRAMES, (300e-6,)) == pytest.approx([100e-6])
