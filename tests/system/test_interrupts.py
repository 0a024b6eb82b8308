"""Signals that wait: what was begun is done first, and they are not lost."""

import os
import signal

import numba
import numpy as np
import pytest
from numba.core.event import Listener, install_listener

from pellucid.jit import kernel
from pellucid.system.interrupts import signals_caught, signals_held

pytestmark = pytest.mark.usefixtures("interruptible")


@kernel(inner=True)
def _added(x, y):
    x[0] += y


@kernel()
def added_twice(x, y):
    _added(x, y)
    _added(x, y)


class Interrupting(Listener):
    """Ctrl-C whenever a kernel is compiled."""

    def on_start(self, event: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    def on_end(self, event: object) -> None:
        pass


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_the_compiler_goes_on_to_the_end_of_the_kernel_that_python_called(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    x = np.zeros(1, np.float32)
    with install_listener("numba:compile", Interrupting()), pytest.raises(KeyboardInterrupt):
        added_twice(x, 1.0)
    assert (len(_added.overloads), len(added_twice.overloads)) == (1, 1)
    assert len(list(tmp_path.rglob("*.nbc"))) == 2
    assert x[0] == 0.0
    added_twice(x, 1.0)
    assert x[0] == 2.0


def test_held_signals_come_after_the_block_once_each_and_to_whom_they_are_for():
    with signals_caught() as caught:
        with signals_held(), signals_held():
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
                os.kill(os.getpid(), number)
            assert caught == []
        assert caught == [signal.SIGINT, signal.SIGTERM]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_held_signal_is_not_lost_with_an_error():
    def fail():
        with signals_held():
            os.kill(os.getpid(), signal.SIGINT)
            raise ValueError

    with pytest.raises(KeyboardInterrupt) as raised:
        fail()
    assert isinstance(raised.value.__context__, ValueError)


def test_a_handler_that_python_did_not_set_stays(monkeypatch):
    """Python does not know it, and could not put it back."""
    handler = signal.getsignal
    with monkeypatch.context() as patch:
        patch.setattr(signal, "getsignal", lambda number: None)
        with signals_held():
            assert handler(signal.SIGINT) is signal.default_int_handler
    assert handler(signal.SIGINT) is signal.default_int_handler
