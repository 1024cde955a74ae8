"""A page that simulates by itself: a model as WebAssembly in the page of its run.

entries     what the page calls of the model
engine.js   how it calls
"""
