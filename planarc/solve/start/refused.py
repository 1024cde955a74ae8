"""What is raised where a mechanism cannot start."""

from planarc.core.diagnostic import PlanarcError


class NotAssembled(PlanarcError):
    """The conditions at the start cannot be met, or contradict each other (R411, R412, R428)."""
