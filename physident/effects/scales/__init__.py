"""Parts of an arm's torque that one share scales on all joints. Start with ``shared_scale``."""
