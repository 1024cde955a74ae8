"""The look of drawn things: known here, drawn by pictures and by the page's script.

module      takes                  gives
---------   --------------------   ----------------------------------------------
shapes      Item                   Shape: forms, measured by length and width
forms       places and widths      Form: a mark without a size, and what is used again
furniture   labels, directions     Forms of bearings, arrows, frames and corners
draw        Item at an instant     marks: outlines, bars, discs, labels, in metres
"""
