"""File formats of recordings, one small file each; every reader returns a ``table.Table``.

A new format is one file with a ``read_...`` function and one line in ``read.FORMATS``, where to start reading.
"""
