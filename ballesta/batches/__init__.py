"""Many designs, each checked in a worker process of its own, with a record of what is done."""
