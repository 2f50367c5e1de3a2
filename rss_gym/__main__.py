"""`python -m rss_gym` is the command `rss-gym`."""

from rss_gym.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
