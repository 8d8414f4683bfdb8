"""One thread for linear algebra: the same bytes whatever the machine, and on small matrices as fast as many."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextvars import ContextVar
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
_LIMITED: ContextVar[bool] = ContextVar("_LIMITED", default=False)


def one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """The function, during which BLAS computes on one thread: the last digits of a sum depend on their number."""

    @functools.wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> T:
        if _LIMITED.get():  # called by another such function
            return function(*args, **kwargs)
        import scipy.linalg  # noqa: F401  (it brings its own BLAS, which must be there to be limited)
        from threadpoolctl import threadpool_limits

        token = _LIMITED.set(True)
        try:
            with threadpool_limits(1, user_api="blas"):
                return function(*args, **kwargs)
        finally:
            _LIMITED.reset(token)

    return limited
