"""Shared libraries from LLVM's objects, without a linker.

objects     an object file read
join        its sections put together, relocations applied, ways to imported functions
elf         a library for Linux
"""
