"""The demo: a generated arm that has changed, its diagnosis, and then the truth."""

from physident.demo.run import Demo, run_demo

__all__ = ["Demo", "run_demo"]
