#!/bin/sh
# The objects compiled for one instruction set define nothing that another could be given by the
# linker: every symbol that may be merged is a template over that set. Argument: the library.
set -eu
foreign=$(nm -C --defined-only "$1" |
  awk '/\.o:$/ { one = /_avx(2|512)\.cc\.o:$/ } one && $2 ~ /^[TVWu]$/' |
  grep -v '(stiefel::Isa)\|DW.ref' || true)
echo "${foreign:-all symbols are of their instruction set}"
[ -z "$foreign" ]
