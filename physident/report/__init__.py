"""The report: a diagnosis as one self-contained page for the person who decides.

``page`` puts the ``sections`` together, ``markup`` escapes every text, ``chart`` draws, ``reread`` finds the recordings.
Start with ``page.write_report``.
"""
