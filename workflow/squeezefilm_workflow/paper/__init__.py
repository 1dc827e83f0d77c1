"""Parts of this paper alone: its claims and tables compared with ours."""
