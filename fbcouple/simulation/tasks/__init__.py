"""What looks at a finished step."""
