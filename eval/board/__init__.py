"""A leaderboard that strangers can enter: they send policies, and whoever runs the board flies them.

An entry is numbers (`entry`), checked without running anything of it. A season (`season`) fixes what is flown: each
suite's own encounters, which everybody may develop on, and sealed ones, whose seeds are published as a commitment and
told when it closes. Flights (`flights`) run in child processes with limits, and go on where a killed process ended.
What comes out is signed (`signing`) and appended to a file in which each line holds the hash of the one before
(`chain`). `breaks` flies what others send against an entry, and `site` makes the pages.
"""
