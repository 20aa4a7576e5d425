"""The topic `plane` of the report."""

from dubins_study.report.topics.plane.section import TOPIC

__all__ = ["TOPIC"]
