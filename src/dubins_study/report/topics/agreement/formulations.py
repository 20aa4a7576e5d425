"""The topic on agreement between formulations."""

from __future__ import annotations

from dubins_study.report.elements.topic import BENCHMARK, Topic
from dubins_study.report.topics.agreement.section import formulations_section

TOPIC = Topic("agreement of formulations", formulations_section, BENCHMARK)
