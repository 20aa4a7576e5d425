"""The topic `limits` of the report; its texts and tables need no numbers of rows."""

from dubins_study.report.topics.limits.section import TOPIC

__all__ = ["TOPIC"]
