"""The topic `runs` of the report; its one small figure is drawn in `section`."""

from dubins_study.report.topics.runs.section import TOPIC

__all__ = ["TOPIC"]
