"""A model leaves the house: a compiled program as a file that other tools run without planarc.

fmu         one call: a compiled model becomes an FMU
idle        what nothing that it computes hangs on, which is left out
refusal     what cannot be exported, told with its line
fits        what was left out of redundant joints
crowds      what its crowds read and set
image       its first content: the assembly found here, at export
module      the code as LLVM modules
shared      of it what many models share
parted      what of it calls the host, or is called by it, and the rest
objects     their machine code, for a kind of processor
emission    of one text, by LLVM, such that it is small
units       function by function, as it is kept for models of other kinds
endings     what a run may end with, or warn of, in words
fmi         the interface: model description and functions of the standard
page        the model in a page: what the page calls, and how
c           the model as C99 that people read
link        shared libraries from objects, and ways to what Windows calls otherwise
archive     files as one
"""
