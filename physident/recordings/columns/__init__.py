"""Which column and which joint of a table is what: by the header's names, by a declared layout, by the names of joints.

Start with ``layout.ColumnLayout``; ``reading.Reading`` holds everything that a user declares about files.
"""
