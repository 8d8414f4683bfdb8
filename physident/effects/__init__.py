"""Effects: the physics that a model is made of, one file for each family.

Every effect is a subclass of ``effect.Effect`` and one line in ``catalogue``; the rest of the package reads what it needs
from the class. Start with ``effect``, then read ``friction`` as an example.
"""
