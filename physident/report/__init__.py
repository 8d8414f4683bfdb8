"""The report: a diagnosis as one self-contained HTML page.

``page`` assembles the ``sections``, ``markup`` escapes every text, ``chart`` draws curves, and ``reread`` reads the
diagnosed recordings again. Start with ``page.write_report``.
"""
