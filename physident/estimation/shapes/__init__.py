"""Parameters that a torque is not linear in: found by variable projection, with what they leave uncertain."""
