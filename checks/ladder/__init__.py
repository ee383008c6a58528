"""The cheapest model of a part whose error bars settle its verdict, up to the solid."""
