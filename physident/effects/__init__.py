"""Effects: the physics a model is made of, one family a file.

Every effect is a subclass of ``effect.Effect`` and one line in ``catalogue``; everything else in the package learns of it
from there. Start with ``effect``, then read ``friction`` as an example.
"""
