"""Parallel loops, written for one chunk and called with the number of chunks.

    @parallel_loop()
    def scale(chunk, values, factor):
        for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(values))):
            values[i] *= factor

    scale(chunks, values, 2.0)  # all chunks, in any order on the threads

As with a vectorised function, one definition stands for the work on one part and for the call on all. The kernel of a chunk is
compiled as `scale_chunk`, and as `scale` a driver with the same arguments, which hands the chunks out to the threads
(`pellucid.jit.parallel`). A driver of several loops, and several drivers of one kernel, are written out.
"""

import functools
import inspect
from collections.abc import Callable
from operator import attrgetter
from typing import Any

from pellucid.jit.joint import joint_region
from pellucid.jit.kernels import kernel
from pellucid.jit.parallel import parallel_by_colour, parallel_for


def parallel_loop(allocates: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Make the decorated kernel of a chunk, whose first argument is its number, a loop over as many chunks as this says.

    The kernel must return nothing; what it raises is lost. Python and kernels call the loop. allocates: as for `kernel`.
    """
    return lambda function: _driver(function, parallel_for, [], allocates)


def parallel_loop_by_colour(gives: str) -> Callable[[Callable[..., Any]], Callable[..., None]]:
    """The same for slabs of points, of which neighbours add to the same nodes and are never done at the same time.

    The second argument has `slabs`, with the number of these in a row (`across`). gives: the argument that neighbours add to,
    or a member of it, such as "walls.gap", as `JointRegion.give` takes it. Python alone calls the loop.
    """
    name, _, member = gives.partition(".")

    def decorate(function: Callable[..., Any]) -> Callable[..., None]:
        parameters = list(inspect.signature(function).parameters)
        place = parameters.index(name)
        driver = _driver(function, parallel_by_colour, [f"{parameters[1]}.slabs.across"])

        @functools.wraps(driver)
        def loop(*arguments: Any) -> None:
            given = arguments[place]
            joint_region.give_at_once(lambda: driver(*arguments), lambda: [attrgetter(member)(given) if member else given])

        return loop

    return decorate


def _driver(function: Any, loop: Any, sizes: list[str], allocates: bool = False) -> Any:
    """The kernel that hands out the chunks, by the name of the function.

    It is made from text, with the arguments of the function: numba is slow to find the types of any number of them (`*others`).
    Messages place it where the function is.
    """
    number, *others = inspect.signature(function).parameters
    given = ", ".join(["chunk_kernel", number, *sizes, *others])
    text = f"def driver({', '.join([number, *others])}): loop({given})"
    file, line = function.__code__.co_filename, function.__code__.co_firstlineno
    known: dict[str, Any] = {"loop": loop}
    exec(compile("\n" * (line - 1) + text, file, "exec"), known)
    driver = functools.wraps(function)(known["driver"])
    function.__name__, function.__qualname__ = f"{function.__name__}_chunk", f"{function.__qualname__}_chunk"
    known["chunk_kernel"] = kernel(inner=True, allocates=allocates)(function)
    return kernel()(driver)
