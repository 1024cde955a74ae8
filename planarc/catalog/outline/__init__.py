"""Outlines of parts from drawings: a path of an SVG or a polyline of a DXF becomes corners.

piece     a line or an arc of an outline, and how finely it must be cut
svg, dxf  a file gives its outlines, in its own units, with y upwards, and the size of the unit
corners   an outline becomes a polygon in metres: counter-clockwise, without crossings
text      the polygon as a class
"""
