"""Reports of a result: the verdict as text, as a page with charts and pictures, and as files."""
