"""What a finding is worth: whether it is new since the model was identified, and whether it takes more than it leaves."""
