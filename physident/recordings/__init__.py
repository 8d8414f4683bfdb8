"""Recordings: the measurements of an arm, without the rows that are physically impossible.

``recording`` is the data; ``load``, ``formats``, ``columns`` and ``rows`` make it from a file or arrays; ``preparation`` turns it into
``signals`` on a uniform clock with velocity and acceleration. Start with ``load.load_recordings``.
"""
