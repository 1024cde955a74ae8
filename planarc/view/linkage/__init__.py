"""A mechanism as an engineer draws it: flat links, pins, blocks on guides, one size for all.

In:   Result, items as its components ask for them (`scene`)
Out:  items whose sizes, colours and order are chosen by the mechanism

    module      takes                    gives
    ---------   ----------------------   ----------------------------------------------
    groups      Result                   Groups: rigid groups, their points, depth, colour
    palette     joints                   colours that neighbours do not share
    plates      Group, items             one flat shape through all points of a group
    slides      item, Groups             a block on its guide, or barrel and rod
    hatches     a curve of the ground    strokes on its solid side
    dress       Result, items            the items as they are drawn

A component names the part that its shape plays (`link`, `mass`, `pin`, `motor`, `slide`,
`ground`); a size of 0 and a colour of `Types.Defaults` leave the choice to the picture.
"""
