"""Commands that plan, simulate or inspect recordings: demo, inspect, design, simulate."""
