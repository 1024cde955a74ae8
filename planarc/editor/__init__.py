"""The language server. What stands above `convert` is free of its protocol:

texts, shelf     what is open in the editor, and libraries around it; last good classes
view, mentions   the names around a text; each place at which a text writes one
meaning          what a name means
check, worker    a text's models checked when typing pauses
facts            what a checked model says of its variables: values, states, blocks
context, words, complete, signature
                 what may be written at a place
hover, references, rename, symbols, tokens, folds, edits, fixes, hints, parts, handbook
                 one question of an editor each
session          all of that together
runs             models run and checked
pages, handover  live pages beside texts, drawn from what a check made
convert          our types as those of the protocol
peer, requests, commands, server
                 the protocol: each request answered by one call
"""
