"""The topic `basins` of the report."""

from dubins_study.report.topics.basins.section import TOPIC

__all__ = ["TOPIC"]
