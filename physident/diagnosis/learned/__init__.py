"""Learned curves in a diagnosis: where laws of the catalogue leave structure, or explain clearly less than a free function does.

``pool`` has the curves that can be tried, ``learn`` accepts them, ``describe`` puts them into words. Start with ``learn``.
"""
