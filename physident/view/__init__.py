"""Pictures of recordings, models and diagnoses."""
