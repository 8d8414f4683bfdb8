"""Dry friction near standstill, where neither its sign nor its size is known.

``transition_width`` finds the speed over which friction turns, ``row_weights`` weighs rows by what it leaves uncertain,
``rest`` gives the friction of a joint at rest its best value inside its band, and ``held_rests`` finds the rests at its edge.
"""
