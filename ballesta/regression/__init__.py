"""Numbers that must not change unseen: baselines beside designs, and pytest that watches them."""
