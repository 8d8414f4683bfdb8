"""The result of a diagnosis: findings, what stays unexplained, the extended model, and the words for all of them.

``findings`` are the records, ``assemble`` makes them from a finished search, ``text`` and ``wording`` print them,
``saved`` reads them back from a file. Start with ``findings``.
"""
