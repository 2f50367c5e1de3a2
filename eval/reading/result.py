"""A record as the result that it was made of, as far as it tells: enough for tables and pages, without a flight."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from rss_gym.eval.evaluate import Result, Scored
from rss_gym.eval.policies import Entry
from rss_gym.eval.reading.plain import RecordError
from rss_gym.eval.reading.record import Policy, Record
from rss_gym.eval.records import SCORES
from rss_gym.eval.suites import SUITES, Suite, find


@dataclass(frozen=True, slots=True)
class RecordedSuite(Suite):
    """A suite with the hash that it had when it was flown."""

    recorded_hash: str = ""

    @property
    def hash(self) -> str:
        """Of the definition that was flown."""
        return self.recorded_hash


@dataclass(frozen=True)
class RecordedEntry(Entry):
    """A policy that was flown; `policy` is None, since nothing builds it."""

    recorded_action: str | None = None
    recorded_hash: str = ""

    @property
    def action(self) -> str | None:
        """What it commanded; None where the record does not tell."""
        return self.recorded_action

    @property
    def hash(self) -> str:
        """Of the policy that was flown."""
        return self.recorded_hash


def definition(record: Record) -> Suite:
    """Today's definition of the record's suite, with the record's parameters."""
    if record.suite in SUITES:
        return dataclasses.replace(find(record.suite), params=record.params)
    return Suite(record.suite, "", record.params, split=record.split)


def result_of(record: Record) -> Result:
    """The result that a record tells of; metrics and hashes are those recorded.

    Raises
    ------
    RecordError
        If a policy has information that the world does not give.
    """
    today = definition(record)
    fields = {item.name: getattr(today, item.name) for item in dataclasses.fields(today)}
    suite = RecordedSuite(**fields | {"split": record.split}, recorded_hash=record.suite_hash)
    scored = tuple(Scored(_entry(record, policy), policy.table, policy.metrics) for policy in record.policies)
    return Result(suite, record.seed, record.episodes, record.official, scored, record.reference, record.first_episode)


def _entry(record: Record, policy: Policy) -> RecordedEntry:
    world = record.params
    able = dict.fromkeys((world.interface.information, "oracle"))
    if policy.information not in able:
        raise RecordError(
            f"{record.folder / SCORES}: information = {policy.information!r} of policy {policy.name!r} must be one of "
            f"{', '.join(able)}, which the world gives"
        )
    interface = world.interface.replace(information=policy.information)
    told = dataclasses.replace(world, interface=interface)
    return RecordedEntry(policy.name, policy.spec, None, told, policy.action, policy.hash)
