"""What a finding may be mistaken for: effects that these recordings cannot tell from it, and those that no motion can. Start with ``rivals``."""
