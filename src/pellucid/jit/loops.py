"""Parallel loops, written for one chunk and called with the number of chunks.

    @parallel_loop()
    def scale(chunk, values, factor):
        for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(values))):
            values[i] *= factor

    scale(chunks, values, 2.0)  # all chunks, in any order on the threads

As for a vectorized function, one definition serves for the work on one chunk and for the call on all chunks. The kernel of
a chunk is compiled as `scale_chunk`. A driver with the same arguments is compiled as `scale`; it distributes the chunks to
the threads (`pellucid.jit.parallel`). A driver of several loops, or several drivers of one kernel, must be written
explicitly.
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
    """Return a decorator that turns the kernel of a chunk into a parallel loop over chunks. The first argument of the
    kernel is the index of the chunk; the first argument of the loop is the number of chunks.

    The kernel must not return a value; exceptions that the kernel raises are lost. Python and kernels can call the loop.
    allocates: see `kernel`.
    """
    return lambda function: _driver(function, parallel_for, [], allocates)


def parallel_loop_by_colour(gives: str) -> Callable[[Callable[..., Any]], Callable[..., None]]:
    """Return a decorator like `parallel_loop` for kernels of a slab of points: slabs that are neighbours add to the same nodes
    and never run at the same time.

    The second argument of the kernel has `slabs`, with the number of slabs in a row (`across`). gives: name of the argument
    that holds the arrays to which neighbouring slabs add, or of a member of an argument, such as "walls.gap"; see
    `JointRegion.give`. Only Python can call the loop.
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
    """Return the driver: a kernel with the name of `function` that distributes the chunks to the threads by the parallel loop
    `loop`.

    function: kernel of one chunk; sizes: expressions for further arguments of the loop, such as the number of slabs in a
    row; allocates: see `kernel`. Its source text is generated with the arguments of the function, since numba is slow to
    determine the types of a variable number of arguments (`*others`). Messages give the location of the function.
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
