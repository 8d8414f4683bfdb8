"""Effects: the physics that a model is made of, one file for each family.

Every effect is a subclass of ``effect.Effect`` and one line in ``catalogue``; the rest of the package reads what it needs
from the class. Velocity friction is in ``friction``; friction that depends on load or
couples joints is in ``transmission``, on past motion in ``hysteresis``, on temperature in ``thermal``. Start with ``effect``, then read ``friction`` as an example.
"""
