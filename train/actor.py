"""The part of an SB3 actor-critic that acts."""

from __future__ import annotations

from typing import Any


def parts(policy: Any) -> tuple[Any, Any]:
    """Hidden layers and the layer of the actions."""
    return policy.mlp_extractor.policy_net, policy.action_net


def parameters(policy: Any) -> list[Any]:
    """All of both."""
    return [parameter for part in parts(policy) for parameter in part.parameters()]


def outputs(policy: Any, rows: Any) -> Any:
    """Mean actions, or logits, of rows (n, d)."""
    hidden, last = parts(policy)
    return last(hidden(rows))


def hold(policy: Any, is_held: bool) -> None:
    """Let an actor that has imitated a rule stay as it is, while the critic learns to judge it, or go on."""
    for parameter in parameters(policy):
        parameter.requires_grad_(not is_held)
    if getattr(policy, "log_std", None) is not None:
        policy.log_std.requires_grad_(not is_held)
