"""Wrong set-ups, named before anything is fitted: signs, order, gains, units, description, and what the effort channel is."""

from physident.setup_checks.check_setup import check_setup
from physident.setup_checks.finding import SetupFinding

__all__ = ["SetupFinding", "check_setup"]
