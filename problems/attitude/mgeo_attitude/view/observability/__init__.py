"""What a plan teaches the filter, what it leaves unknown, and what simpler plans would do."""
