"""Response of a part: unit loads, stress, buckling and the numerical error bar."""
