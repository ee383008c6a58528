"""A design as plain data: its schema, materials, units and errors."""
