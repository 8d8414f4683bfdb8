"""The result of a diagnosis: findings, the unexplained residual, the extended model, and their text.

``findings`` are the records, ``assemble`` makes them from a finished search, ``text`` and ``wording`` print them,
``saved`` reads them back from a file. Start with ``findings``.
"""
