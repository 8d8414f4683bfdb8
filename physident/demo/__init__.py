"""The demo: a simulated arm with one hidden change, its diagnosis, and then the truth.

``arms`` draws the change, ``run`` runs the demo. Start with ``run``.
"""
