"""The command `rss-gym`. Every sub-command imports what it needs when it runs."""

from __future__ import annotations

import argparse
import itertools
import json
import os
import sys
from collections.abc import Sequence
from typing import Any

DEMO_EPISODES = 10_000


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns the exit status, 2 for bad input."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    options = _parser().parse_args(given, argparse.Namespace(given=given))
    from rss_gym.params import ParamsError

    try:
        status = options.run(options)
    except ParamsError as error:
        print(f"rss-gym: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("rss-gym: interrupted; nothing was written", file=sys.stderr)
        return 130
    except Exception as error:
        from rss_gym.core import NotFiniteError
        from rss_gym.eval.episodes import PolicyError

        if not isinstance(error, (NotFiniteError, PolicyError)):
            raise
        print(f"rss-gym: {error}", file=sys.stderr)
        return 1
    return int(status or 0)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rss-gym", description="UAV collision avoidance with ranges from radio signal strength."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    command = commands.add_parser("list", help="ids, policies, channel presets, families, recipes and suites")
    command.add_argument("--json", action="store_true", help="as JSON")
    command.set_defaults(run=_list)

    command = commands.add_parser("eval", help="score policies on the same encounters")
    command.add_argument(
        "--policy",
        nargs="+",
        action="extend",
        required=True,
        metavar="NAME",
        help="such as none orthogonal:radius_m=60; all for every one that can fly there",
    )
    command.add_argument("--suite", default="encounter-v0", help="see rss-gym list; highway-v0 and others are roads")
    command.add_argument("--episodes", type=int, help="default: the suite's")
    command.add_argument("--seed", type=int, help="default: the suite's")
    command.add_argument(
        "--channel", nargs="+", action="extend", metavar="PRESET|FILE", help="channel, or several to draw from"
    )
    command.add_argument(
        "--information",
        nargs="+",
        action="extend",
        metavar="LEVEL",
        help="oracle, positions or ranges; several give a folder each in DIR",
    )
    command.add_argument("--estimator", help="of the range: ekf-coloured, ekf-white, ekf-white-r or ls")
    command.add_argument("--tracker", help="of the intruder's relative state: latest, fused or bearings")
    command.add_argument("--families", nargs="+", action="extend")
    command.add_argument("--workers", type=int, default=1)
    command.add_argument("--reference", metavar="NAME", help="policy that completed-only figures are compared with")
    command.add_argument("--out", required=True, metavar="DIR", help="new folder for scores and tables")
    command.add_argument("--csv", action="store_true", help="tables as CSV too")
    command.add_argument("--json", action="store_true", help="print scores.json instead of the table")
    command.set_defaults(run=_eval)

    command = commands.add_parser("verify", help="recompute a record's metrics and fly some of its episodes again")
    command.add_argument("folder", metavar="DIR", help="folder with scores.json")
    command.add_argument("--all", action="store_true", dest="every", help="fly all episodes again, not 1 %%")
    command.add_argument("--seed", type=int, default=0, help="draws another sample of episodes")
    command.add_argument("--trust", action="store_true", help="run the code of policies given as module:attribute too")
    command.add_argument("--workers", type=int, default=1)
    command.add_argument("--json", action="store_true", help="as JSON")
    command.set_defaults(run=_verify)

    command = commands.add_parser("leaderboard", help="one page of ranked tables from several records")
    command.add_argument("folders", nargs="+", metavar="DIR", help="folders with scores.json")
    command.add_argument("--out", required=True, metavar="SITE", help="new folder for index.html and the records")
    command.set_defaults(run=_leaderboard)

    command = commands.add_parser("train", help="train agents by a recipe, or go on with a run")
    command.add_argument("recipe", nargs="?", metavar="RECIPE", help="name of a shipped recipe, or a TOML file")
    command.add_argument("--env", help="another id than the recipe's")
    command.add_argument("--steps", type=int, help="decisions of one seed, over all rows")
    command.add_argument("--seeds", type=int, help="trainings that differ in their seed only; default: 1")
    command.add_argument("--workers", type=int, default=1, help="processes, each with one seed at a time")
    command.add_argument(
        "--channel", nargs="+", action="extend", metavar="PRESET|FILE", help="channel, or several to draw from"
    )
    command.add_argument("--information", metavar="LEVEL", help="oracle, positions or ranges")
    command.add_argument("--resume", metavar="RUN", help="go on with the run in this folder from its checkpoints")
    command.add_argument(
        "--set",
        nargs="+",
        action="extend",
        metavar="KEY=VALUE",
        help="such as algorithm.learning_rate=3e-4 world.comfort_m=30",
    )
    command.add_argument("--out", metavar="RUN", help="new folder for the run")
    command.set_defaults(run=_train)

    command = commands.add_parser("export", help="make a policy folder, which cannot run code")
    command.add_argument("source", metavar="RUN|MODEL", help="folder of a run, or a .zip of SB3")
    command.add_argument("--out", required=True, metavar="DIR", help="new folder for the policy")
    command.add_argument("--env", help="the id the .zip was trained in; default: rss_gym/Encounter-v0")
    command.add_argument("--algorithm", help="ppo, recurrent-ppo or sac; default: what the .zip looks like")
    command.add_argument(
        "--set",
        nargs="+",
        action="extend",
        metavar="KEY=VALUE",
        help="parameters of the world of the .zip, such as intruders=2",
    )
    command.set_defaults(run=_export)
    command = commands.add_parser("calibrate", help="a channel from radio logs, with range errors on a test")
    command.add_argument("fit", nargs="+", metavar="FIT", help="logs to fit")
    command.add_argument(
        "--test",
        nargs="+",
        action="extend",
        default=[],
        metavar="TEST",
        help="logs to test on; default: the last third of each record",
    )
    command.add_argument("--format", default="csv", help="csv or mavlink")
    command.add_argument("--columns", default="", metavar="t=..,rss=..,dist=..", help="names of a table's columns")
    command.add_argument("--out", required=True, metavar="FILE", help="channel to write, such as channel.toml")
    command.add_argument("--report", metavar="DIR", help="new folder for the page and calibration.json")
    command.add_argument("--json", action="store_true", help="print everything as JSON instead of the table")
    command.set_defaults(run=_calibrate)

    command = commands.add_parser("paper", help="every figure and number of the paper, beside what comes out")
    command.add_argument("--out", required=True, metavar="DIR", help="new folder for paper.json and index.html")
    command.add_argument("--seed", type=int, default=0)
    command.add_argument("--quick", action="store_true", help="fewer repetitions: wider intervals, in some seconds")
    command.set_defaults(run=_paper)

    command = commands.add_parser("study", help="fly what the documentation claims, and print it beside its criteria")
    command.add_argument("name", metavar="NAME", help="world: whether the radio decides, nothing wins blind, RL learns")
    command.add_argument(
        "--episodes", type=int, default=20_000, help="encounters of a row, unless its section says more"
    )
    command.add_argument("--decisions", type=int, default=3_000_000, help="length of each training")
    command.add_argument("--seeds", type=int, default=5, help="trainings")
    command.add_argument("--workers", type=int, default=2)
    command.add_argument("--out", metavar="FILE", help="write the page as Markdown too")
    command.set_defaults(run=_study)

    command = commands.add_parser(
        "demo", help="the rule of the paper over its radius beside other rules and learned agents, on two channels"
    )
    command.add_argument("--episodes", type=int, default=DEMO_EPISODES)
    command.add_argument("--workers", type=int, default=2)
    command.add_argument("--out", metavar="DIR", help="new folder; default: runs/demo, or the next free number")
    command.set_defaults(run=_demo)
    return parser


def _list(options: argparse.Namespace) -> None:
    from rss_gym.listing import listing

    content = listing()
    if options.json:
        print(json.dumps(content, indent=1))
        return
    for title, rows in content.items():
        print(f"{title}:")
        width = max(len(name) for name in rows)
        for name, text in rows.items():
            print(f"  {name:<{width}}  {text}")


def _eval(options: argparse.Namespace) -> None:
    from rss_gym.eval import records, report, text
    from rss_gym.files import check_new, new_folder
    from rss_gym.params import ParamsError

    out = check_new(options.out)
    _see_modules_here()
    names = ("channel", "estimator", "tracker", "families")
    changes: dict[str, Any] = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    levels = options.information or []
    twice = next((level for level in levels if levels.count(level) > 1), None)
    if twice is not None:
        raise ParamsError(f"information {twice!r} is given twice")
    if len(levels) < 2:
        results = {"": _flown(options, options.out, **changes, **({"information": levels[0]} if levels else {}))}
    else:
        for level in levels:  # before hours are flown on the first
            _scorer(options).check(options.policy, options.suite, options.reference, **changes, information=level)
        with new_folder(out) as folder:
            results = {level: _flown(options, folder / level, **changes, information=level) for level in levels}
    if options.json:
        scores = {level: (out / level / records.SCORES).read_text(encoding="utf-8") for level in results}
        several = {level: json.loads(content) for level, content in scores.items()}
        print(json.dumps(several, indent=1) if len(levels) > 1 else scores[""].rstrip())
        return
    columns = _scorer(options).COLUMNS if _is_road(options) else text.COLUMNS
    for level, result in results.items():
        print(text.table(result, columns, text.coloured(sys.stdout)))
        print(f"scores: {os.path.join(options.out, level, records.SCORES)}")
        print(f"report: {os.path.join(options.out, level, report.REPORT)}")


def _flown(options: argparse.Namespace, out: str | os.PathLike[str], **changes: Any) -> Any:
    """Fly, or drive, and save one record."""
    result = _scorer(options).evaluate(
        options.policy,
        suite=options.suite,
        episodes=options.episodes,
        seed=options.seed,
        workers=options.workers,
        reference=options.reference,
        **changes,
    )
    if _is_road(options):
        _scorer(options).save(result, out, options.csv)
    else:
        from rss_gym.eval import records, report

        records.save(result, out, options.csv, report.write)
    return result


def _is_road(options: argparse.Namespace) -> bool:
    from rss_gym.eval import road

    return options.suite in road.SUITES


def _scorer(options: argparse.Namespace) -> Any:
    """The module with `check` and `evaluate` for the suite."""
    import importlib

    return importlib.import_module("rss_gym.eval.road" if _is_road(options) else "rss_gym.eval.evaluate")


def _verify(options: argparse.Namespace) -> int:
    from rss_gym.eval import verify

    if options.trust:
        _see_modules_here()
    verdict = verify.verify(
        options.folder, every=options.every, trust=options.trust, seed=options.seed, workers=options.workers
    )
    print(json.dumps(verdict.to_dict(), indent=1) if options.json else verify.report(verdict))
    return 0 if verdict.verified else 1


def _leaderboard(options: argparse.Namespace) -> None:
    from rss_gym.eval import leaderboard

    site = leaderboard.build(options.folders, options.out)
    for note in site.notes:
        print(note)
    print(f"leaderboard: {site.page}")


def _train(options: argparse.Namespace) -> int:
    from rss_gym.params import ParamsError
    from rss_gym.train import recipe, road, run

    changes = recipe.parse_changes(options.set or [])
    short = {"recipe.env": options.env, "recipe.steps": options.steps}
    short |= {"world.channel": options.channel, "world.information": options.information}
    changes |= {key: value for key, value in short.items() if value is not None}
    try:
        if options.resume is None:
            if options.recipe is None or options.out is None:
                shipped = ", ".join(recipe.recipes())
                raise ParamsError(f"name a recipe and --out, or a run to --resume; shipped recipes: {shipped}")
            seeds = 1 if options.seeds is None else options.seeds
            if road.is_road(options.recipe):
                road.start(road.load(options.recipe, changes), options.out, seeds, options.workers, options.given)
            else:
                run.start(recipe.load(options.recipe, changes), options.out, seeds, options.workers, options.given)
        else:
            if changes or any(value is not None for value in (options.recipe, options.seeds, options.out)):
                raise ParamsError("--resume goes on with a run as it was begun: give it nothing but --workers")
            run.resume(options.resume, options.workers)
    except KeyboardInterrupt:
        how = f"go on with rss-gym train --resume {options.resume or options.out}"
        if options.resume is None and road.is_road(options.recipe):
            how = "a training on a road is short and begins anew"
        print(f"rss-gym: interrupted; {how}", file=sys.stderr)
        return 130
    return 0


def _export(options: argparse.Namespace) -> None:
    from rss_gym.params import ParamsError
    from rss_gym.train import convert, recipe

    if os.path.isdir(options.source):
        if any(value is not None for value in (options.env, options.algorithm, options.set)):
            raise ParamsError("--env, --algorithm and --set are for a .zip; a run knows its own world")
        difference = convert.export_run(options.source, options.out)
    else:
        print(f"Reading {options.source} runs code from it.", file=sys.stderr, flush=True)
        world = recipe.parse_changes(options.set or [])
        env = options.env or "rss_gym/Encounter-v0"
        difference = convert.export_model(options.source, options.out, env, options.algorithm, world)
    print(f"greatest difference from SB3's actions on 1,000 observations: {difference:.2g}")
    print(f"policy: {options.out}")


def _calibrate(options: argparse.Namespace) -> None:
    from rss_gym.calibration.logs import read
    from rss_gym.eval.studies.calibration import output
    from rss_gym.eval.studies.calibration.calibrate import calibrate
    from rss_gym.params import ParamsError

    output.check_outputs(options.out, options.report)
    columns = _columns(options.columns)
    fitted = {os.path.realpath(name) for name in options.fit}
    twice = next((name for name in options.test if os.path.realpath(name) in fitted), None)
    if twice is not None:
        raise ParamsError(f"log {twice!r} is to be fitted and tested; a test needs a log of its own")
    fit = read(options.fit, options.format, columns)
    test = read(options.test, options.format, columns) if options.test else None
    result = calibrate(fit, test or (), (*fit.notes, *(test.notes if test else ())))
    output.save(result, options.out, options.report)
    if options.json:
        print(json.dumps(output.to_dict(result), indent=1, allow_nan=False))
        return
    print(output.table(result))
    print(f"channel: {options.out}")
    if options.report is not None:
        print(f"report: {os.path.join(options.report, output.PAGE)}")


def _columns(text: str) -> dict[str, str]:
    """`t=time,rss=power` as a dict."""
    from rss_gym.params import ParamsError

    columns: dict[str, str] = {}
    for item in filter(None, text.split(",")):
        key, equals, name = (part.strip() for part in item.partition("="))
        if not (key and equals and name) or key in columns:
            raise ParamsError(f"columns must be KEY=NAME pairs of different keys with commas between, got {item!r}")
        columns[key] = name
    return columns


def _paper(options: argparse.Namespace) -> None:
    from rss_gym.eval import paper
    from rss_gym.files import check_new

    check_new(options.out)
    reproduction = paper.reproduce(paper.QUICK if options.quick else None, options.seed)
    folder = paper.write(reproduction, options.out)
    print(reproduction.summary)
    print(f"numbers: {folder / paper.NUMBERS}")
    print(f"page: {folder / paper.PAGE}")


def _study(options: argparse.Namespace) -> int:
    from rss_gym.eval import studies
    from rss_gym.files import write_text
    from rss_gym.params import ParamsError, suggestion

    if options.name not in studies.STUDIES:
        raise ParamsError(f"study {options.name!r} is unknown{suggestion(options.name, studies.STUDIES)}")
    scale = studies.Scale(options.episodes, options.workers, options.decisions, options.seeds)
    sections = []
    for section in studies.STUDIES[options.name](scale):
        print(section.text, flush=True)
        sections.append(section)
        if options.out:  # after each: an interrupted study keeps what it has flown
            write_text(options.out, studies.page(options.name, sections))
    missed = [str(criterion) for section in sections for criterion in section.criteria if not criterion.met]
    print(f"{sum(len(section.criteria) for section in sections) - len(missed)} criteria met, {len(missed)} missed")
    return 0


def _see_modules_here() -> None:
    """Let `module:attribute` name a module of the working folder; an installed command does not look there."""
    here = os.getcwd()
    if here not in sys.path:
        sys.path.append(here)


def _demo(options: argparse.Namespace) -> None:
    from rss_gym import demo

    print(f"report: {demo.run(options.out or _unused('runs/demo'), options.episodes, options.workers)}")


def _unused(stem: str) -> str:
    """`stem`, or the first of stem-2, stem-3, ... that does not exist."""
    names = itertools.chain([stem], (f"{stem}-{number}" for number in itertools.count(2)))
    return next(name for name in names if not os.path.exists(name))
