"""The made-up flights of `sensed_flights` are imported by name."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
