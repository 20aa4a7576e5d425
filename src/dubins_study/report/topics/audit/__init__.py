"""The topic `audit` of the report."""

from dubins_study.report.topics.audit.section import TOPIC

__all__ = ["TOPIC"]
