"""The program: reads a design file, checks its parts and says what it found."""
