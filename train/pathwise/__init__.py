"""Learning by the gradient through the flight: the encounter's own equations of motion, differentiated.

`flights` records encounters that the policy flew, `surrogate` flies them again in PyTorch, `algorithm` follows the
gradient. What the radio, the filters and the other aircraft did is held as recorded; only the agent moves otherwise.
"""
