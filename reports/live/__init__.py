"""The live view: stress of every part, superposed in the reader's browser at any position.

What Python hands over is written down in viewer.js; fields.js superposes it.
"""
