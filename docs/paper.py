"""Makes the table of docs/paper.md and the summary in the README: python docs/paper.py (a minute or two)."""

from pathlib import Path

from opponents import put

from rss_gym.eval import paper
from rss_gym.eval.paper import page
from rss_gym.eval.records import versions

ROOT = Path(__file__).resolve().parent.parent


def main() -> None:
    """Run the reproduction and write both."""
    result = paper.reproduce()
    used = ", ".join(f"{name} {number}" for name, number in versions().items())
    made = f"Seed {result.study.seed}; made by `python docs/paper.py` with {used}."
    put(ROOT / "docs" / "paper.md", "paper", f"{result.summary}\n\n{page.markdown(result.numbers)}\n\n{made}")
    put(ROOT / "README.md", "paper", result.summary)


if __name__ == "__main__":
    main()
