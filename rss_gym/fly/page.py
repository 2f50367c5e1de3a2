"""The page itself: one file that needs no network, of a template, the translated world and the scripts that draw."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
from pathlib import Path
from typing import Any

from markupsafe import Markup

import rss_gym
from rss_gym.baselines.agent import load
from rss_gym.baselines.shipped import AGENTS
from rss_gym.eval.suites import Suite, find
from rss_gym.fly.encounters import SEARCHED, Encounter, choose
from rss_gym.fly.world import program
from rss_gym.pages import page
from rss_gym.pages.markup import renderer
from rss_gym.params import Params, ParamsError, suggestion

FOLDER = Path(__file__).parent
template = renderer(__file__)
SCRIPTS = (page.CANVAS, FOLDER / "draw.js", FOLDER / "fly.js")
COUNT = 40  # encounters of a page


def build(suite: str = "encounter-v0", agent: str = "pathwise-plane", count: int = COUNT) -> str:
    """The page, as HTML.

    Parameters
    ----------
    suite : str
        What is flown: a planar suite of the air in which messages tell positions.
    agent : str
        The shipped agent to fly against.
    count : int
        How many encounters the page offers.

    Raises
    ------
    ParamsError
        For an unknown name, or a suite or agent that a page cannot fly.
    """
    flown = find(suite)
    if agent not in AGENTS:
        raise ParamsError(f"agent {agent!r} is unknown{suggestion(agent, AGENTS)}")
    params = flown.params
    is_air = flown.domain.name == "air" and isinstance(params, Params)
    if not is_air or not params.encounter.planar or params.interface.information != "positions":
        raise ParamsError(
            f"suite {suite!r} cannot be flown on a page: it takes a planar suite of the air "
            "whose messages tell positions"
        )
    world = program(flown, load(AGENTS[agent], params))
    return render(flown, agent, choose(flown, count), world)


def render(suite: Suite, agent: str, encounters: list[Encounter], world: str) -> str:
    """The page of these encounters, on the translated world."""
    script = world + "".join(path.read_text(encoding="utf-8") for path in SCRIPTS)
    if "</script" in script:
        raise ValueError("a script must not hold the end of its element")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    style = page.style() + (FOLDER / "fly.css").read_text(encoding="utf-8")
    params: Any = suite.params
    data = {
        "agent": agent,
        "key": f"rss_gym fly {suite.hash[:12]} {digest[:16]}",  # a tally of another world or agent is none of this page
        "encounters": [dataclasses.asdict(encounter) for encounter in encounters],
        "decision_s": params.clock.decision_s,
        "speed_mps": params.aircraft.speed_max_mps,
        "collision_m": params.zone.collision_m,
        "snmac_m": params.zone.snmac_horizontal_m,
        "zone_m": params.zone.radius_m,
    }
    return str(
        template(
            "fly.html",
            agent=agent,
            suite=suite.name,
            digest=suite.hash[:12],
            version=rss_gym.__version__,
            count=len(encounters),
            searched=SEARCHED,
            zone_m=f"{params.zone.radius_m:.0f}",
            speed_max=f"{params.aircraft.speed_max_mps:g}",
            decision_s=f"{params.clock.decision_s:g}",
            collision_m=f"{params.zone.collision_m:g}",
            snmac_m=f"{params.zone.snmac_horizontal_m:g}",
            snmac_price=f"{params.reward.snmac_price_m:,.0f}",
            collision_price=f"{params.reward.collision_price_m:,.0f}",
            # Nothing is fetched, and no script runs but this one.
            policy=f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; base-uri 'none'",
            style=Markup(style),
            data=Markup(page.embedded(data)),
            script=Markup(script),
        )
    )
