"""Estimators of range compared on radio logs after a fit of the channel, and the pages that say so."""
