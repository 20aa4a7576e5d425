"""The topic `belief` of the report."""

from dubins_study.report.topics.belief.section import TOPIC

__all__ = ["TOPIC"]
