"""The demo: a generated arm in which one effect was changed, its diagnosis, and then the truth.

``arms`` draws the change, ``run`` plays the demo. Start with ``run``.
"""
