"""The language server. All but `server`, `session` and `convert` is free of its protocol:

texts        what is open in the editor, read as far as it can be; last good classes
shelf        libraries read lazily, open texts in the place of their files
sight        what a place in a text can name, and what a name there means
mentions     each place at which a text writes a name
check        a text's models checked, one after the other
worker       a thread that does that when typing pauses, and gives up what is overtaken
facts        what a checked model says of its variables: values, states, blocks
complete, hover, signature, symbols, references, rename, tokens, folds, hints, fixes
             one question of an editor each
pages        live pages beside texts
convert      our types as those of the protocol
server       the protocol's requests, each answered by one call
"""
