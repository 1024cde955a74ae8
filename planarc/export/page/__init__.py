"""A page that simulates by itself: a model as WebAssembly in the page of its run.

page        one call: a compiled model and its run become a page
drawing     what is shown of a run, as steps over its columns
module      the model as WebAssembly
entries     what the page calls of it

told        words for its events, its warnings and its end

engine.js   starts and runs the module; record.js makes what is shown of its rows, told.js what is
            told; pull.js drags parts; own.js answers the page's controls with all of these
"""
