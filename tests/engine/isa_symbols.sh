#!/bin/sh
# Checks that no object compiled for one instruction set defines a symbol that the linker could give
# to code for another: every symbol that may be merged is a template over the instruction set.
# Argument: the library.
set -eu
foreign=$(nm -C --defined-only "$1" |
  awk '/\.o:$/ { one = /_avx(2|512)\.cc\.o:$/ } one && $2 ~ /^[TVWu]$/' |
  grep -v '(stiefel::Isa)\|DW.ref' || true)
echo "${foreign:-all symbols are of their instruction set}"
[ -z "$foreign" ]
