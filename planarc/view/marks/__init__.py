"""The look of drawn things: known here, drawn by pictures and by the page's script.

module      takes                  gives
---------   --------------------   ----------------------------------------------
shapes      Item                   Shape: forms, measured by length and width
draw        Item at an instant     marks: outlines, bars, discs, labels, in metres
"""
