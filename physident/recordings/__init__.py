"""Recordings: what an arm measured, with the rows that cannot be trusted left out and named.

``recording`` is the data, ``load`` and ``rows`` make it from a file or arrays, ``signals`` puts it on a uniform clock and
through the filter. Start with ``load.load_recordings``.
"""
