"""What a finding may be mistaken for: effects that these recordings cannot tell from it, and those that no motion can.

``imitators`` are what nobody may name though it looks like a cause. Start with ``rivals``.
"""
