"""Dry friction near standstill, where neither its sign nor its size is known.

``transition_width`` finds the speed over which friction turns, ``rest_rows`` weighs rows by what it leaves uncertain, and
``rest`` gives the friction of a joint at rest its best value inside its band.
"""
