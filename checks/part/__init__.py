"""A part under the loads of its cycles, in its own axes."""
