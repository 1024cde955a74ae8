"""Shared libraries from LLVM's objects (`planarc.runtime.link`), without a linker.

elf         a library for Linux
pe          one for Windows
macho       one for macOS, signed
wasm        a module for WebAssembly, from its own kind of objects
"""
