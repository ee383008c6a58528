"""How a part responds: unit loads, stress, buckling and the numerical error bar."""
