"""Dry friction near standstill: how much a row still says about it, and the speed over which it turns.

``rest_rows`` weighs rows by what the sign of the velocity leaves open, ``transition_width`` finds each joint's width.
"""
