"""Shared libraries from LLVM's objects, without a linker.

objects     object files read and put together
join        its sections put together, relocations applied, ways to imported functions
elf         a library for Linux
pe          one for Windows
macho       one for macOS, signed
wasm        a module for WebAssembly, from its own kind of objects
"""
