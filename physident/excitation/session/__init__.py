"""Sessions: the recordings of one visit to the arm, chosen for questions that are open.

``questions`` says what is open, ``pieces`` makes motions that keep every limit, ``evidence`` says what a motion would show,
``choice`` picks the pieces that answer most, and ``session`` is the result. Start with ``plan``.
"""
