"""What belongs to the paper alone: its claims and tables beside ours."""
