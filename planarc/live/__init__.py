"""The live page: a model whose parameters are moved by sliders.

    module      what it does
    ---------   ---------------------------------------------------------------------
    choices     which replaceable parts a model has, and what may stand in their place
    variant     one of the models that the page may be moved to
    session     the model as the page has it now: compiles, runs, tells what is wrong
    watch       notices that a file of the model was edited
    server      answers the page, and nobody else

The page itself is `page`: that of `view.page.live`, with what it asks of the server.
"""
