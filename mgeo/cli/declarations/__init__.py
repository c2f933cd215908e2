"""Words, options and help of the commands; what they do is imported when they are run."""
