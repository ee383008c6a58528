"""What differs between two designs or two results."""
