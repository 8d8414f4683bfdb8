"""By how much a healthy arm differs from day to day, and which findings are no more than that. Start with ``usual_friction``."""
