"""Plans made better without a global search: good starts, local polish, no unneeded maneuvers."""

from mgeo_attitude.refine.polish import polish, polish_steps
from mgeo_attitude.refine.splitting import n_commands, split, without_unneeded
from mgeo_attitude.refine.starts import starts

__all__ = ["n_commands", "polish", "polish_steps", "split", "starts", "without_unneeded"]
